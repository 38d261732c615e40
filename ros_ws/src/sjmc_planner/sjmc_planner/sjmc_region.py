"""The region D that a robot sweeps at its own velocity (SJMC thesis, 3.4.1), straight or turning.

The robot is a box about its base. Seen from it, a point that stands moves against the robot's own
velocity: along a line, or along a circle about the turning center (-v_y / w, v_x / w). It is in D
if it gets into the box, and the time until then is exact: the first crossing of a side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import Velocity

_TOL = 1e-9
_STRAIGHT = 1e-6  # rad/s: slower turning is none
_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Box:
    """What a robot takes up, from its base: m ahead, behind and to either side."""

    front: float
    rear: float
    half_width: float

    def grown(self, margin: float) -> Box:
        """Return it with air around."""
        return Box(self.front + margin, self.rear + margin, self.half_width + margin)

    def corners(self) -> np.ndarray:
        """Return its corners, counter-clockwise, shape (4, 2), m."""
        f, r, h = self.front, self.rear, self.half_width
        return np.array([[f, h], [-r, h], [-r, -h], [f, -h]])


def box_of(robot: RobotConfig) -> Box:
    """Return a robot's box; the square around its circle if it names none or may move sideways."""
    if robot.half_width_m > 0.0 and robot.drive == "differential":
        return Box(robot.front_m, robot.rear_m, robot.half_width_m)
    return Box(robot.radius_m, robot.radius_m, robot.radius_m)


def entry_times(points: np.ndarray, velocity: Velocity, box: Box) -> np.ndarray:
    """Return when the robot at a steady velocity gets to points that stand.

    Args:
        points: In the base frame, shape (N, 2), m.
        velocity: Of the base.
        box: What it takes up.

    Returns:
        Shape (N,), s; 0 for points in the box, inf for points outside D.
    """
    v, b = velocity, box
    args = np.ascontiguousarray(points, dtype=float), v.x, v.y, v.yaw_rate
    return np.asarray(_entry_times(*args, b.front, b.rear, b.half_width))


@numba.njit(cache=True, nogil=True)
def _entry_times(points, vx, vy, w, front, rear, half):  # type: ignore[no-untyped-def]
    times = np.full(len(points), np.inf)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        if -rear <= x <= front and abs(y) <= half:
            times[i] = 0.0
        elif abs(w) > _STRAIGHT:
            times[i] = _turning_entry(x, y, vx, vy, w, front, rear, half)
        else:
            times[i] = _straight_entry(x, y, vx, vy, front, rear, half)
    return times


@numba.njit(cache=True, nogil=True)
def _straight_entry(x, y, vx, vy, front, rear, half):  # type: ignore[no-untyped-def]
    first, last = 0.0, np.inf
    for at, v, low, high in ((x, -vx, -rear, front), (y, -vy, -half, half)):
        if v == 0.0:
            if at < low or at > high:
                return np.inf
            continue
        a, b = (low - at) / v, (high - at) / v
        first, last = max(first, min(a, b)), min(last, max(a, b))
    return first if first <= last else np.inf


@numba.njit(cache=True, nogil=True)
def _turning_entry(x, y, vx, vy, w, front, rear, half):  # type: ignore[no-untyped-def]
    cx, cy = -vy / w, vx / w
    rho, begin = math.hypot(x - cx, y - cy), math.atan2(y - cy, x - cx)
    best = np.inf
    for side in (front, -rear):
        cos = (side - cx) / max(rho, _TOL)
        if abs(cos) <= 1.0:
            for angle in (math.acos(cos), -math.acos(cos)):
                if abs(cy + rho * math.sin(angle)) <= half + _TOL:
                    best = min(best, _turn_time(begin, angle, w))
    for side in (half, -half):
        sin = (side - cy) / max(rho, _TOL)
        if abs(sin) <= 1.0:
            for angle in (math.asin(sin), math.pi - math.asin(sin)):
                if -rear - _TOL <= cx + rho * math.cos(angle) <= front + _TOL:
                    best = min(best, _turn_time(begin, angle, w))
    return best


@numba.njit(cache=True, nogil=True)
def _turn_time(begin, end, w):  # type: ignore[no-untyped-def]
    """Return how long a point takes from one angle to another; it turns against the robot."""
    turn = (begin - end) if w > 0.0 else (end - begin)
    return (turn % _TURN) / abs(w)


@numba.njit(cache=True, nogil=True)
def free_ways(bearings, points, radii, front, half):  # type: ignore[no-untyped-def]
    """Return how far the robot's front gets along each course, straight on, until it meets a disk.

    Args:
        bearings: Of the courses, from the base, shape (K,), rad; the robot faces along them.
        points: Middles of the disks, shape (M, 2), m.
        radii: Of them, shape (M,), m; 0 for points.
        front: How far the robot reaches ahead of its base, m.
        half: Half of its width, m.

    Returns:
        Shape (K,), m; inf where nothing is met. What is beside the robot already is not ahead.
    """
    ways = np.full(len(bearings), np.inf)
    for k in range(len(bearings)):
        c, s = math.cos(bearings[k]), math.sin(bearings[k])
        for i in range(len(points)):
            across = abs(c * points[i, 1] - s * points[i, 0])
            reach = half + radii[i]
            if across < reach:
                along = c * points[i, 0] + s * points[i, 1]
                deep = across - half
                cut = math.sqrt(radii[i] ** 2 - deep**2) if deep > 0.0 else radii[i]
                if along > front:
                    ways[k] = min(ways[k], max(along - cut - front, 0.0))
    return ways
