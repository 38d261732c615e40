"""Size from two landmarks (team paper, 3.3): a circle, and the ray that meets it.

With the origin midway between the landmarks and y along them, L apart and seen under the angle
theta, a robot is on (x + L / (2 tan theta))^2 + y^2 = (L / (2 sin theta))^2. The angle from the
first landmark to the second, counter-clockwise, is signed: its sign says on which side of them the
robot is, so that the circle is one and not two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import wrap_angle
from multi_localizer.team_problem import TeamProblem

_LEAST_ANGLE = 0.02  # rad; nearer to 0 or pi the circle is a line


@dataclass(frozen=True, eq=False)
class SeenPair:
    """Two landmarks and the angle under which a robot sees them.

    Attributes:
        first: Position, (2,), m.
        second: Position, (2,), m.
        angle: From the first to the second, counter-clockwise, (-pi, pi].
    """

    first: np.ndarray
    second: np.ndarray
    angle: float


def two_landmarks(problem: TeamProblem, robot: int) -> SeenPair | None:
    """Return the two landmarks of the robot's, farthest apart, whose identity their class tells."""
    seen = {}
    for k in np.flatnonzero(problem.mark_robot == robot):
        kind = problem.mark_kind[k]
        if problem.kind_start[kind + 1] - problem.kind_start[kind] == 1:
            seen[int(problem.kind_start[kind])] = float(problem.mark_bearing[k])
    pairs = [
        SeenPair(problem.marks[a], problem.marks[b], wrap_angle(seen[b] - seen[a]))
        for a in seen
        for b in seen
        if a < b
    ]
    pairs = [pair for pair in pairs if _LEAST_ANGLE < abs(pair.angle) < np.pi - _LEAST_ANGLE]
    if not pairs:
        return None
    return max(pairs, key=lambda pair: float(np.hypot(*(pair.second - pair.first))))


def circle(pair: SeenPair) -> tuple[np.ndarray, float]:
    """Return middle, (2,), and radius of the circle on which the robot is."""
    span = pair.second - pair.first
    length = float(np.hypot(*span))
    aside = np.array([-span[1], span[0]]) / length  # left of the way from first to second
    middle = 0.5 * (pair.first + pair.second) + aside * length / (2.0 * np.tan(pair.angle))
    return middle, abs(length / (2.0 * np.sin(pair.angle)))


def circle_distance(
    place: np.ndarray, along: float, pair: SeenPair, near: np.ndarray | None
) -> float | None:
    """Return how far along a ray the circle of `pair` is met, m; None if it is not.

    Of two places the one on the right side of the landmarks counts, then the one nearer to `near`.
    """
    middle, radius = circle(pair)
    step = np.array([np.cos(along), np.sin(along)])
    half = float(step @ (middle - place))
    rest = half * half - float((middle - place) @ (middle - place)) + radius * radius
    if rest < 0.0:
        return None
    fars = [far for far in (half - np.sqrt(rest), half + np.sqrt(rest)) if far > 0.0]
    fars = [far for far in fars if _is_on_side(place + far * step, pair)]
    if not fars:
        return None
    if near is None:
        return float(fars[0]) if len(fars) == 1 else None
    return float(min(fars, key=lambda far: float(np.hypot(*(place + far * step - near)))))


def _is_on_side(point: np.ndarray, pair: SeenPair) -> bool:
    """Return whether the landmarks appear in the order seen."""
    a, b = pair.first - point, pair.second - point
    return bool((a[0] * b[1] - a[1] * b[0]) * pair.angle > 0.0)
