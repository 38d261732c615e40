"""Obstacles that a map knows and a laser does not show: glass.

A laser sees through a pane, so a robot that leaves its path beside one would drive into it. The
corners of the map's occupied cells near the robot stand for them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numba
import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sjmc_planner.planning import Decision, Goal, Method, Obstacles, RobotState

POINTS_APART = 0.05  # points nearer to each other than this leave no gap between them, m
_CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
_TURN = 2.0 * math.pi


def occupied_corners(grid: OccupancyMap, occupied_from: int) -> np.ndarray:
    """Return the corners of a map's occupied cells in the map's frame, shape (K, 2), m.

    Args:
        grid: The map.
        occupied_from: Cells of this occupancy and more are obstacles, %.
    """
    cells = np.argwhere(grid.cells >= occupied_from)
    corners = np.unique((cells[:, None] + _CORNERS).reshape(-1, 2), axis=0)
    return grid.to_points(corners - 0.5)


def near_points(points_map: np.ndarray, T_map_base: SE2, reach: float) -> np.ndarray:
    """Return those points that are near the robot, in its own frame, shape (K, 2), m."""
    off = points_map - np.array([T_map_base.x, T_map_base.y])
    is_near = (off * off).sum(axis=1) <= reach * reach
    return T_map_base.inverse() @ points_map[is_near]


def merged(obstacles: Obstacles) -> Obstacles:
    """Return a scan whose beams end at the known obstacles too; what no beam looked at stays so."""
    if not len(obstacles.known):
        return obstacles
    scan = obstacles.scan
    points = obstacles.T_base_sensor.inverse() @ obstacles.known
    ranges = _cut(
        np.asarray(scan.ranges, dtype=float), points, scan.angle_min, scan.angle_increment,
        max(scan.range_min, 1e-3), POINTS_APART,
    )  # fmt: skip
    return Obstacles(replace(scan, ranges=ranges), obstacles.T_base_sensor)


class OnMergedScan:
    """A method that knows nothing but scans, shown the known obstacles as if seen.

    Args:
        method: The method.
    """

    def __init__(self, method: Method) -> None:
        self._method = method

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now."""
        return self._method.decide(state, merged(obstacles), goal, has_debug=has_debug)


def hides(sensor: np.ndarray, places: np.ndarray, known: np.ndarray, width: float) -> np.ndarray:
    """Tell which places a laser sees only through, or on, a known obstacle, shape (N,), bool.

    Args:
        sensor: Where it looks from, shape (2,), m.
        places: Shape (N, 2), m.
        known: The obstacles, shape (K, 2), m.
        width: How near to the line of sight an obstacle must be, m.
    """
    if not len(known) or not len(places):
        return np.zeros(len(places), dtype=bool)
    way = places - sensor
    length2 = np.maximum((way * way).sum(axis=1), 1e-12)
    off = known[None] - sensor
    share = np.clip((off * way[:, None]).sum(axis=2) / length2[:, None], 0.0, 1.0)
    apart = np.hypot(*(share[:, :, None] * way[:, None] - off).transpose(2, 0, 1))
    return np.asarray((apart <= width).any(axis=1))


@numba.njit(cache=True, nogil=True)
def _cut(ranges, points, angle_min, step, nearest, apart):  # type: ignore[no-untyped-def]
    """Return ranges that end at points nearer than they do, each `apart` wide."""
    cut = ranges.copy()
    around = int(np.rint(_TURN / abs(step)))
    for i in range(len(points)):
        x, y = points[i]
        r = max(math.hypot(x, y), nearest)
        half = math.atan(0.5 * apart / r) / abs(step)
        middle = (math.atan2(y, x) - angle_min) / step
        for n in range(int(math.ceil(middle - half)), int(math.floor(middle + half)) + 1):
            k = n % around
            if k < len(cut) and cut[k] > r:  # never of NaN
                cut[k] = r
    return cut
