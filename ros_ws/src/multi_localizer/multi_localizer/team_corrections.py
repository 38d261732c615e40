"""Bearings made as if all were taken at the moment and of the landmarks' middles.

The solver takes all robots at one time and landmarks as points. Once it has an answer, what it
leaves out is known well enough to be taken out of the bearings: the way of the robot that sees, and
of the one that is seen, between the image and the moment, and the side of a wide landmark. The turn
of the robot that sees is out already. A second answer then rests on the corrected bearings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.team_inbox import Moment
from multi_localizer.team_views import RobotView, TeamSolution

Motion = Callable[[str, int, int], SE2 | None]
"""(name, from, to): camera of a robot at one stamp seen from that at another; None: not known."""


def corrected_views(
    moment: Moment, solution: TeamSolution, landmarks: Landmarks, motion: Motion
) -> tuple[tuple[RobotView, ...], float]:
    """Return the views of a moment with what is known of them taken out.

    Args:
        moment: What was seen, and when.
        solution: A first answer: poses of cameras.
        landmarks: By class.
        motion: By odometry.

    Returns:
        The views, and by how much a bearing was changed at most, rad.
    """
    views = []
    most = 0.0
    for name, sight in moment.sights.items():
        if name not in solution.estimates:
            views.append(sight.view)
            continue
        back = _Back(moment.stamp_ns, sight.stamp_ns, solution, motion, name)
        view = sight.view
        robots = back.robots(solution.identities.get(name), len(view.bearings))
        marks = {
            kind: back.marks(_found(solution, name, kind), landmarks.get(kind, ()), len(bearings))
            for kind, bearings in view.landmark_bearings.items()
        }
        most = max([most, *(float(np.abs(d).max(initial=0.0)) for d in (robots, *marks.values()))])
        views.append(_with_changes(view, robots, marks))
    return tuple(views), most


class _Back:
    """One robot's image, seen from the moment."""

    def __init__(
        self, now_ns: int, then_ns: int, solution: TeamSolution, motion: Motion, name: str
    ) -> None:
        self._now_ns, self._then_ns = now_ns, then_ns
        self._solution, self._motion = solution, motion
        self._now = solution.estimates[name].pose
        way = motion(name, now_ns, then_ns)
        self._then = self._now if way is None else self._now @ way

    def robots(self, identities: np.ndarray | None, num: int) -> np.ndarray:
        """Return the change of each bearing to a robot, rad, (M,)."""
        changes = np.zeros(num)
        for k, who in enumerate([] if identities is None else identities):
            name = self._solution.names[who] if who >= 0 else ""
            if name in self._solution.estimates:
                seen = self._solution.estimates[name].pose
                way = self._motion(name, self._now_ns, self._then_ns)
                was = seen if way is None else seen @ way
                changes[k] = self._change(_place(was), _place(seen))
        return changes

    def marks(
        self, identities: np.ndarray | None, marks: Sequence[Landmark], num: int
    ) -> np.ndarray:
        """Return the change of each bearing to a landmark of one class, rad, (K,)."""
        changes = np.zeros(num)
        for k, which in enumerate([] if identities is None else identities):
            if 0 <= which < len(marks):
                mark = marks[which]
                changes[k] = self._change(mark.point_seen(_place(self._then)), mark.position)
        return changes

    def _change(self, was: np.ndarray, is_now: np.ndarray) -> float:
        """Return the direction of a thing now less that of where it was seen then."""
        return wrap_angle(_direction(self._now, is_now) - _direction(self._then, was))


def _found(solution: TeamSolution, name: str, kind: str) -> np.ndarray | None:
    return solution.landmark_identities.get(name, {}).get(kind)


def _place(pose: SE2) -> np.ndarray:
    return np.array([pose.x, pose.y])


def _direction(pose: SE2, place: np.ndarray) -> float:
    """Return the direction in the map; the turn since the image is out of the bearing already."""
    return math.atan2(place[1] - pose.y, place[0] - pose.x)


def _with_changes(
    view: RobotView, robots: np.ndarray, marks: Mapping[str, np.ndarray]
) -> RobotView:
    changed = {kind: b + marks[kind] for kind, b in view.landmark_bearings.items()}
    return replace(view, bearings=view.bearings + robots, landmark_bearings=changed)
