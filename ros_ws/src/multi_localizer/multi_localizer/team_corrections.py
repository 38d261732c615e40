"""Bearings made as if all were taken at the moment and of the landmarks' middles.

The solver takes all robots at one time and landmarks as points. Once it has an answer, what it
leaves out is known well enough to be taken out of the bearings: the way of the robot that sees, and
of the one that is seen, between the image and the moment, and the side of a wide landmark. The turn
of the robot that sees is out already. A second answer then rests on the corrected bearings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

Motion = Callable[[str, int, int], SE2 | None]
"""(name, from, to): camera of a robot at one stamp seen from that at another; None: not known."""


@dataclass(frozen=True, eq=False)
class Now:
    """The moment that bearings are brought to.

    Attributes:
        stamp_ns: When it is.
        taken_ns: When each robot's bearings were taken.
        motion: By odometry.
    """

    stamp_ns: int
    taken_ns: Mapping[str, int]
    motion: Motion


def corrected_views(
    views: Sequence[RobotView], now: Now, solution: TeamSolution, landmarks: Landmarks
) -> tuple[RobotView, ...]:
    """Return views of a moment with what is known of them taken out.

    Args:
        views: What was seen, turned to the moment.
        now: When it was seen, and how robots moved since.
        solution: A first answer: poses of cameras.
        landmarks: By class.

    Returns:
        The views; those of robots without a pose as they were.
    """
    changed = []
    for view in views:
        if view.name not in solution.estimates:
            changed.append(view)
            continue
        back = _Back(now, solution, view.name)
        robots = back.robots(solution.identities.get(view.name), len(view.bearings))
        found = solution.landmark_identities.get(view.name, {})
        marks = {
            kind: bearings + back.marks(found.get(kind), landmarks.get(kind, ()), len(bearings))
            for kind, bearings in view.landmark_bearings.items()
        }
        bearings = view.bearings + robots
        changed.append(replace(view, bearings=bearings, landmark_bearings=marks))
    return tuple(changed)


def largest_change(before: Sequence[RobotView], after: Sequence[RobotView]) -> float:
    """Return by how much a bearing of the same views differs at most, rad."""
    most = 0.0
    for a, b in zip(before, after, strict=True):
        pairs = [(a.bearings, b.bearings)]
        pairs += [(a.landmark_bearings[k], b.landmark_bearings[k]) for k in a.landmark_bearings]
        changes = [float(np.abs(x - y).max(initial=0.0)) for x, y in pairs]
        most = max([most, *changes])
    return most


def believed(views: Sequence[RobotView], landmarks: Landmarks) -> TeamSolution:
    """Return what the robots' own poses say of themselves, and which landmarks they must see.

    Good enough to know which end of a wide landmark a robot has before it.
    """
    rough = {view.name: view.rough for view in views if view.rough is not None}
    marks = {
        view.name: {
            kind: _nearest(rough[view.name].pose, landmarks.get(kind, ()), bearings)
            for kind, bearings in view.landmark_bearings.items()
        }
        for view in views
        if view.name in rough
    }
    names = tuple(view.name for view in views)
    return TeamSolution(names, estimates=rough, landmark_identities=marks)


def _nearest(pose: SE2, marks: Sequence[Landmark], bearings: np.ndarray) -> np.ndarray:
    """Return for each bearing the landmark nearest to it in direction; `NOBODY` without any."""
    if not marks:
        return np.full(len(bearings), NOBODY)
    seen = [_direction(pose, mark.point_seen(_place(pose))) - pose.yaw for mark in marks]
    return np.array(
        [int(np.argmin([abs(wrap_angle(b - s)) for s in seen])) for b in bearings], dtype=int
    )


class _Back:
    """One robot's image, seen from the moment."""

    def __init__(self, now: Now, solution: TeamSolution, name: str) -> None:
        self._now_ns, self._then_ns = now.stamp_ns, now.taken_ns[name]
        self._solution, self._motion = solution, now.motion
        self._now = solution.estimates[name].pose
        way = now.motion(name, self._now_ns, self._then_ns)
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


def _place(pose: SE2) -> np.ndarray:
    return np.array([pose.x, pose.y])


def _direction(pose: SE2, place: np.ndarray) -> float:
    """Return the direction in the map; the turn since the image is out of the bearing already."""
    return math.atan2(place[1] - pose.y, place[0] - pose.x)
