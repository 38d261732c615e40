"""Poses of one moment, joined over time by odometry: who is who is taken from each moment.

Each moment is solved on its own; which bearing is whose goes on to the joint `TeamFilter`. That
begins with a robot where the moment has it, and anew where both contradict each other, as when the
robot was carried away. Robots without odometry keep the moment's pose.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_sightings import Sighting
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

Motion = Callable[[str, int, int], SE2 | None]
_MARK = "{} {}"
_CONTRADICTION = 40.0  # chi-squared of 3 degrees: once in 10^8


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
        marks = {
            _MARK.format(kind, k): place
            for kind, places in landmarks.items()
            for k, place in enumerate(places)
        }
        self._filter = TeamFilter(team, marks, config)
        self._last_ns: dict[str, int] = {}

    def follow(
        self, stamp_ns: int, views: Sequence[RobotView], solution: TeamSolution, motion: Motion
    ) -> TeamSolution:
        """Return a moment's solution with the poses that all moments so far make together.

        Args:
            stamp_ns: Of the moment; later than the last.
            views: Bearings as if all were taken then.
            solution: What they came to alone.
            motion: Of cameras, by odometry.
        """
        joined = {v.name for v in views if self._predict(v.name, stamp_ns, motion)}
        told: set[str] = set()
        before = self._filter.estimates()
        for name, estimate in solution.estimates.items():
            if name in joined and not _agrees(before.get(name), estimate):
                self._filter.forget(name)
                self._filter.place(name, estimate)
                told.add(name)  # all that this view knows
        for view in views:
            if view.name in joined - told:
                self._filter.update(view.name, _sightings(view, solution, joined), stamp_ns)
        known = self._filter.estimates()
        estimates: dict[str, PoseEstimate] = {
            name: known.get(name, estimate) if name in joined else estimate
            for name, estimate in solution.estimates.items()
        }
        return replace(solution, estimates=estimates, joint_cov=None)

    def _predict(self, name: str, stamp_ns: int, motion: Motion) -> bool:
        """Move a robot up to a stamp; one whose odometry does not tell is forgotten."""
        last_ns = self._last_ns.get(name)
        way = None if last_ns is None else motion(name, last_ns, stamp_ns)
        if way is None:
            self._filter.forget(name)
            way = SE2.identity()
            if motion(name, stamp_ns - 1, stamp_ns) is None:
                self._last_ns.pop(name, None)
                return False
        self._filter.predict(name, way, stamp_ns)
        self._last_ns[name] = stamp_ns
        return True


def _agrees(before: PoseEstimate | None, now: PoseEstimate) -> bool:
    """Return whether a pose can be that of the filter, up to errors that never happen."""
    return before is not None and mahalanobis(before, now) < _CONTRADICTION


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
