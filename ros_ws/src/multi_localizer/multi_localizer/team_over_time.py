"""Poses of one moment, joined over time by odometry: who is who is taken from each moment.

Each moment is solved on its own; which bearing is whose goes on to the joint `TeamFilter`, and so
do the robots' own poses where they rest on something else. That begins with a robot where a moment
has it, with all that the moment says of how it stands to the others. Where some moments in a row
agree with each other against it, as when the robot was carried away, it begins anew; until then one
of the two is wrong, and the pose is said to be as uncertain as that. Robots without odometry keep
the moment's pose. When stamps go back, nothing of what was before counts.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference
from multi_localizer.team_contradictions import Contradictions
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_sightings import Sighting
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

Motion = Callable[[str, int, int], SE2 | None]
_MARK = "{} {}"


class TeamOverTime:
    """Follows the cameras of a team.

    Args:
        team: Names of all robots.
        landmarks: Positions by class, (K, 2) each, m.
        config: Of the filter.
    """

    def __init__(
        self, team: Sequence[str], landmarks: Mapping[str, np.ndarray], config: TeamFilterConfig
    ) -> None:
        """Start with nobody located."""
        self._marks = {
            _MARK.format(kind, k): place
            for kind, places in landmarks.items()
            for k, place in enumerate(places)
        }
        self._team, self._config = tuple(team), config
        self._newest_ns: int | None = None
        self._begin()

    def follow(
        self,
        stamp_ns: int,
        views: Sequence[RobotView],
        solution: TeamSolution,
        motion: Motion,
        own: Mapping[str, PoseEstimate] | None = None,
    ) -> TeamSolution:
        """Return a moment's solution with the poses that all moments so far make together.

        Args:
            stamp_ns: Of the moment; one that is not later than the last begins all anew.
            views: Bearings as if all were taken then.
            solution: What they came to alone.
            motion: Of cameras, by odometry.
            own: Of cameras, by what the robots know from elsewhere; part of `solution`, too.
        """
        if self._newest_ns is not None and stamp_ns <= self._newest_ns:
            self._begin()
        self._newest_ns = stamp_ns
        joined = {v.name for v in views if self._predict(v.name, stamp_ns, motion)}
        before = self._filter.estimates()
        now = {name: e for name, e in solution.estimates.items() if name in joined}
        against = self._against.find(now, before)
        fresh = [name for name in now if name not in before or against.get(name, False)]
        doubted = against.keys() - set(fresh)
        held = [name for name in now if name in before and name not in against]
        self._place(fresh, held, solution)
        told = {name: _sightings(v, solution, joined - doubted) for v in views for name in [v.name]}
        for name in sorted(joined - doubted):
            self._learn(name, told[name], {*fresh}, stamp_ns)
        for name in sorted({*held} & (own or {}).keys() - {*solution.suspects}):
            self._filter.update_pose(name, (own or {})[name], stamp_ns)
        return self._answer(solution, joined, doubted)

    def _begin(self) -> None:
        self._filter = TeamFilter(self._team, self._marks, self._config)
        self._against = Contradictions()
        self._last_ns: dict[str, int] = {}
        self._newest_ns = None

    def _predict(self, name: str, stamp_ns: int, motion: Motion) -> bool:
        """Move a robot up to a stamp; one whose odometry does not tell is forgotten."""
        last_ns = self._last_ns.get(name)
        way = None if last_ns is None else motion(name, last_ns, stamp_ns)
        if way is None:
            self._filter.forget(name)
            self._against.forget(name)
            way = SE2.identity()
            if motion(name, stamp_ns - 1, stamp_ns) is None:
                self._last_ns.pop(name, None)
                return False
        self._filter.predict(name, way, stamp_ns)
        self._against.move(name, way)
        self._last_ns[name] = stamp_ns
        return True

    def _place(self, fresh: Sequence[str], held: Sequence[str], solution: TeamSolution) -> None:
        """Begin with robots where the moment has them, seen from those that are followed."""
        if not fresh:
            return
        order = [list(solution.estimates).index(name) for name in (*fresh, *held)]
        rows = (3 * np.array(order)[:, None] + np.arange(3)).ravel()
        found = [solution.estimates[name] for name in (*fresh, *held)]
        cov = np.zeros((rows.size, rows.size))
        for k, estimate in enumerate(found):
            cov[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = estimate.cov
        if solution.joint_cov is not None:
            cov = solution.joint_cov[np.ix_(rows, rows)]
        mean = np.concatenate([estimate.pose.as_array() for estimate in found])
        self._filter.place_jointly(fresh, held, mean, cov)

    def _learn(
        self, name: str, sightings: Sequence[Sighting], fresh: Collection[str], stamp_ns: int
    ) -> None:
        """Take a view into the filter, but for what has made the poses of `fresh` already."""
        new = []
        for sighting in sightings:
            if name in fresh or sighting.meanings[0] in fresh:
                self._filter.note_seen(name, sighting.meanings[0], stamp_ns)
            else:
                new.append(sighting)
        self._filter.update(name, new, stamp_ns)

    def _answer(
        self, solution: TeamSolution, joined: Collection[str], doubted: Collection[str]
    ) -> TeamSolution:
        known = self._filter.estimates()
        estimates: dict[str, PoseEstimate] = {}
        for name, estimate in solution.estimates.items():
            estimates[name] = known.get(name, estimate) if name in joined else estimate
            if name in doubted and name in known:
                off = difference(estimate.pose, known[name].pose)
                wide = known[name].cov + np.outer(off, off)
                estimates[name] = PoseEstimate(known[name].pose, wide)
        notes = tuple(f"{name}: this moment contradicts its track" for name in sorted(doubted))
        return replace(
            solution, estimates=estimates, joint_cov=None, notes=(*solution.notes, *notes)
        )


def _sightings(view: RobotView, solution: TeamSolution, joined: Collection[str]) -> list[Sighting]:
    """Return the bearings of a view to landmarks and to robots whose odometry is known."""
    found = []
    whose = solution.identities.get(view.name, np.zeros(0, dtype=int))
    for bearing, who in zip(view.bearings, whose, strict=False):
        if who != NOBODY and solution.names[who] in joined:
            found.append(Sighting(float(bearing), (solution.names[who],)))
    marks = solution.landmark_identities.get(view.name, {})
    for kind, bearings in view.landmark_bearings.items():
        for bearing, which in zip(bearings, marks.get(kind, ()), strict=False):
            if which != NOBODY:
                found.append(Sighting(float(bearing), (_MARK.format(kind, which),)))
    return found
