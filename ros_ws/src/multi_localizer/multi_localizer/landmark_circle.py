"""Method 1 (team paper, 2.3 and 3.3): the circle through two landmarks and the angle between them.

A robot that sees landmark a at bearing d_a and b at d_b stands where the angle theta = d_b - d_a is
seen: on a circle through both. The paper gives it for landmarks on the y axis, L apart:

    (x + L / (2 tan theta))^2 + y^2 = (L / (2 sin theta))^2

With theta counter-clockwise from a to b there is one such circle; folded into 0..180 degrees there
would be its mirror image too. Two landmarks leave a circle, a third one a point: the circles
through (a, b) and (b, c) meet in b and at the robot. More are settled by least squares over the
distances to the circles of all pairs.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2

_PARALLEL = 1e-6  # sine below which robot and landmarks are taken to lie on one line
_ROUNDS = 20
_STILL_M = 1e-9


@dataclass(frozen=True)
class Circle:
    """A circle on the floor: `center` (2,), m, and `radius`, m."""

    center: np.ndarray
    radius: float


def circle_of_pair(a: np.ndarray, b: np.ndarray, angle: float) -> Circle | None:
    """Return where landmark b is seen `angle` to the left of landmark a (team paper, 3.3).

    Args:
        a: Position of the landmark, (2,), m.
        b: Of another one, (2,), m.
        angle: Bearing of b less that of a, rad.

    Returns:
        The circle; None where it is a line (angle 0 or pi).
    """
    L = float(np.hypot(*(b - a)))
    s = math.sin(angle)
    if abs(s) < _PARALLEL or L == 0.0:
        return None
    left = np.array([a[1] - b[1], b[0] - a[0]]) / L
    return Circle(0.5 * (a + b) + left * (L / (2.0 * math.tan(angle))), L / (2.0 * abs(s)))


def meet_again(first: Circle, second: Circle, shared: np.ndarray) -> np.ndarray | None:
    """Return where two circles that share a point meet besides, (2,); None if they are one."""
    way = second.center - first.center
    length = float(np.hypot(*way))
    if length < _PARALLEL * max(first.radius, second.radius):
        return None
    along = way / length
    to_shared = shared - first.center
    foot = first.center + along * float(along @ to_shared)
    return np.asarray(2.0 * foot - shared)  # mirrored over the line of both centers


def circle_fix(points: np.ndarray, bearings: np.ndarray) -> SE2 | None:
    """Return the pose from three bearings or more, as published: all pairs weigh the same.

    Args:
        points: Positions of the landmarks, (N, 2), m.
        bearings: Where they are seen, (N,), rad.

    Returns:
        The pose; None if fewer than three landmarks, or no circle or no single place, come out.
    """
    if not np.all(np.isfinite(bearings)):
        return None
    circles = {
        (i, j): circle
        for i, j in itertools.combinations(range(len(points)), 2)
        if (circle := circle_of_pair(points[i], points[j], bearings[j] - bearings[i])) is not None
    }
    places = [place for place in _meetings(circles, points) if np.all(np.isfinite(place))]
    if not places:
        return None
    centers = np.array([circle.center for circle in circles.values()])
    radii = np.array([circle.radius for circle in circles.values()])
    start = min(places, key=lambda place: _distance_sum(place, centers, radii))
    place = _nearest_to_all(start, centers, radii)
    return None if place is None else pose_at(place, points, bearings)


def pose_at(place: np.ndarray, points: np.ndarray, bearings: np.ndarray) -> SE2:
    """Return the pose at a place (2,) in which landmarks are seen at bearings."""
    off = np.arctan2(points[:, 1] - place[1], points[:, 0] - place[0]) - bearings
    yaw = math.atan2(np.sin(off).sum(), np.cos(off).sum())
    return SE2(float(place[0]), float(place[1]), yaw)


def _meetings(circles: dict[tuple[int, int], Circle], points: np.ndarray) -> list[np.ndarray]:
    found = []
    for (pair, first), (other, second) in itertools.combinations(circles.items(), 2):
        shared = set(pair) & set(other)
        if len(shared) == 1:
            place = meet_again(first, second, points[shared.pop()])
            if place is not None:
                found.append(place)
    return found


def _distance_sum(place: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> float:
    off = np.hypot(*(place - centers).T) - radii
    return float(off @ off)


def _nearest_to_all(start: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> np.ndarray | None:
    """Return the place with the least sum of squared distances to circles (Gauss-Newton)."""
    place = np.array(start)
    for _ in range(_ROUNDS):
        ways = place - centers
        lengths = np.maximum(np.hypot(*ways.T), 1e-12)
        J, off = ways / lengths[:, None], lengths - radii
        H = J.T @ J
        if np.linalg.det(H) < _PARALLEL**2:
            return None
        step = np.linalg.solve(H, J.T @ off)
        place = place - step
        if np.hypot(*step) < _STILL_M:
            break
    return place if np.all(np.isfinite(place)) else None
