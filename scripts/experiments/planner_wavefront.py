"""The wave as a local method: the way is made again from all that was seen, at every step.

This is Wavefront as the thesis's Table 2.2 means it, used to avoid obstacles: what is known of the
surroundings (a certainty grid, kept as for VFH+ but wide enough to hold the goal) is a map, the
cheapest way over it is planned anew by the parts of `wavefront_planner`, and a point a little ahead
on it is driven to as the histogram methods drive theirs.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from floornav_common.grid import FREE, OCCUPIED, OccupancyMap
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.path_target import PathTarget
from sjmc_planner.wavefront_config import WavefrontConfig
from sjmc_planner.wavefront_plan import CostMap, NoWayError
from sjmc_planner.windowed import Choice, View, WindowedMethod

_REACH_M, _CELL_M = 14.0, 0.15
_AHEAD_M, _BESIDE_M = 0.6, 1.5  # on the way; of map around what is known


class WavefrontPeer(WindowedMethod):
    """Wavefront, planned again at every step.

    Args:
        config: Robot, rhythm and tolerance.
    """

    def __init__(self, config: LocalPlannerConfig) -> None:
        histogram = replace(config.histogram, window_m=_REACH_M, cell_m=_CELL_M)
        super().__init__(config.robot, histogram, cycle_of(config))
        self._planning = WavefrontConfig(
            radius_m=config.robot.radius_m, margin_m=config.robot.margin_m, goal_search_m=1.0
        )

    def _choose(self, view: View) -> Choice:
        """Return the bearing of a point a little ahead on the way."""
        grid = map_of(view.cells.points, view.goal.point)
        try:
            way = CostMap(grid, self._planning).plan(np.zeros(2), view.goal.point)
        except NoWayError:
            return Choice(np.zeros(0), -1, 0.0)
        ahead = PathTarget(way.points, _AHEAD_M).goal(SE2.identity())
        return Choice(np.array([ahead.bearing]), 0, self._steering.fastest(view.goal))


def cycle_of(config: LocalPlannerConfig) -> Cycle:
    """Return the rhythm of a runner by its settings."""
    return Cycle(
        period=config.control_period_s, goal_tolerance=config.goal_tolerance_m,
        unseen_gap=config.unseen_gap_rad,
    )  # fmt: skip


def map_of(points: np.ndarray, goal: np.ndarray) -> OccupancyMap:
    """Return a map in the base frame that holds the robot, its goal and what stands around.

    Args:
        points: What is occupied, shape (M, 2), m.
        goal: Where to, shape (2,), m.
    """
    held = np.concatenate((points, goal[None], np.zeros((1, 2))))
    low, high = held.min(axis=0) - _BESIDE_M, held.max(axis=0) + _BESIDE_M
    width, height = (math.ceil(float(v) / _CELL_M) for v in high - low)
    cells = np.full((height, width), FREE, dtype=np.int8)
    grid = OccupancyMap(cells, _CELL_M, SE2(float(low[0]), float(low[1]), 0.0))
    rows = grid.to_cells(points)
    cells[rows[:, 0], rows[:, 1]] = OCCUPIED
    return grid
