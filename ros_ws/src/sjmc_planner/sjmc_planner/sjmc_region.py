"""The region D that a robot sweeps (SJMC thesis, 3.4.1): straight on along a course.

The robot is a box about its base that faces along the course; D is the strip ahead of it (3.7: D
goes with the course). What a robot sweeps while it turns, at its own velocity and under its limits,
is looked ahead for in `sjmc_rollout`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sjmc_planner.config import RobotConfig


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
