"""From a moment to poses: some rounds of the solver, rough poses carried from the answer before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.landmarks import Landmarks, positions
from multi_localizer.pose_estimate import PoseEstimate, moved
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_confirmed import is_confirmed
from multi_localizer.team_corrections import Now, believed, corrected_views, largest_change
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_inbox import Moment, TeamInbox
from multi_localizer.team_over_time import TeamOverTime
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import RobotView, TeamSolution

_WORTH_SD = 0.1
_ROUNDS = 3
_NEAR_M = 2.0  # how far robots are apart at least, most of the time
_LOOSEST_RAD = 0.3
_NO_EVIDENCE = np.diag([0.5**2, 0.5**2, 0.3**2])
"""Added to a pose of the answer before: where to search, not the same knowledge once more."""


@dataclass(frozen=True, eq=False)
class TeamAnswer:
    """What a moment came to.

    Attributes:
        moment: What was seen.
        solution: Of the cameras.
        bases: Poses of base_link by name, of the robots that may be believed.
        most_change: By how much a bearing was corrected at most, rad.
    """

    moment: Moment
    solution: TeamSolution
    bases: Mapping[str, PoseEstimate]
    most_change: float = 0.0


class TeamAnswers:
    """Solves one moment after the other.

    Args:
        inbox: Of the team, for its motion.
        landmarks: By class.
        config: Of the solver.
        filter_config: Of the filter that joins moments; None for each moment on its own.
    """

    def __init__(
        self,
        inbox: TeamInbox,
        landmarks: Landmarks,
        config: TeamConfig,
        filter_config: TeamFilterConfig | None = None,
    ) -> None:
        """Start without an answer."""
        self._filter_config = filter_config
        self._last: TeamAnswer | None = None
        self._over_time: TeamOverTime | None = None
        self.config = config
        self.poses_use_landmarks = True
        self._inbox, self._landmarks = inbox, landmarks
        self._positions = positions(landmarks)
        self.forget()

    def solve(self, moment: Moment) -> TeamAnswer:
        """Return the poses at a moment."""
        start = tuple(self._prepared(view, moment.stamp_ns) for view in moment.views)
        views = self._corrected(start, moment, believed(start, self._landmarks))
        solution = solve_team(self._loosened(views, moment), self._positions, self.config)
        for _ in range(_ROUNDS):
            before, views = views, self._corrected(start, moment, solution)
            if largest_change(before, views) < _WORTH_SD * self.config.bearing_sd_rad:
                break
            solution = solve_team(views, self._positions, self.config)
        if self._over_time is not None:
            own = self._own_poses(moment)
            solution = self._over_time.follow(moment.stamp_ns, views, solution, self._motion, own)
        most = largest_change(start, views)
        bases = self._bases(solution, views, len(moment.missing))
        self._last = TeamAnswer(moment, solution, bases, most)
        return self._last

    def configure(self, config: TeamConfig, filter_config: TeamFilterConfig | None) -> None:
        """Go on with other values."""
        self.config, self._filter_config = config, filter_config
        self._inbox.solver = config
        self.forget()

    def forget(self) -> None:
        """Start anew: the clock jumped."""
        self._last = self._over_time = None
        if self._filter_config is not None:
            names = tuple(self._inbox.robots)
            self._over_time = TeamOverTime(names, self._positions, self._filter_config)

    def _corrected(
        self, views: tuple[RobotView, ...], moment: Moment, solution: TeamSolution
    ) -> tuple[RobotView, ...]:
        taken_ns = {name: sight.stamp_ns for name, sight in moment.sights.items()}
        now = Now(moment.stamp_ns, taken_ns, self._motion)
        return corrected_views(views, now, solution, self._landmarks)

    def _loosened(self, views: tuple[RobotView, ...], moment: Moment) -> tuple[RobotView, ...]:
        """Return views whose bearings may be off by the robots' ways since, not known in them."""
        ways = [
            self._motion(name, sight.stamp_ns, moment.stamp_ns)
            for name, sight in moment.sights.items()
        ]
        longest = max([way.distance for way in ways if way is not None], default=0.0)
        sd = math.hypot(self.config.bearing_sd_rad, longest / _NEAR_M)
        if longest / _NEAR_M < _WORTH_SD * self.config.bearing_sd_rad:
            return views
        return tuple(replace(view, bearing_sd=min(sd, _LOOSEST_RAD)) for view in views)

    def _motion(self, name: str, from_ns: int, to_ns: int) -> SE2 | None:
        return self._inbox.robots[name].camera_motion(from_ns, to_ns)

    def _own_poses(self, moment: Moment) -> dict[str, PoseEstimate]:
        """Return where robots are by themselves, if that tells more than their bearings."""
        return {
            view.name: view.rough
            for view in moment.views
            if view.rough is not None
            and not (self.poses_use_landmarks and any(map(len, view.landmark_bearings.values())))
        }

    def _prepared(self, view: RobotView, stamp_ns: int) -> RobotView:
        """Return a view with a start for the search, and whether that is evidence."""
        if view.rough is not None:
            return replace(view, rough_from_landmarks=self.poses_use_landmarks)
        last, robot = self._last, self._inbox.robots[view.name]
        if last is None or view.name not in last.bases or robot.mount is None:
            return view
        base = robot.carried_base(last.bases[view.name], last.moment.stamp_ns, stamp_ns)
        if base is None:
            return view
        guess = moved(PoseEstimate(base.pose, base.cov + _NO_EVIDENCE), robot.mount)
        return replace(view, rough=guess, rough_from_landmarks=True)

    def _bases(
        self, solution: TeamSolution, views: tuple[RobotView, ...], num_away: int
    ) -> dict[str, PoseEstimate]:
        bases = {}
        for name, estimate in solution.estimates.items():
            mount = self._inbox.robots[name].mount
            is_said = is_confirmed(solution, views, name, self.config, num_away)
            if mount is not None and is_said:
                bases[name] = moved(estimate, mount.inverse())
        return bases
