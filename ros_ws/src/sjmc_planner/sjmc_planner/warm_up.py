"""Compiles every kernel, so that the first command is no later than the rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.planning import Goal, Obstacles, RobotState, Velocity
from sjmc_planner.wavefront_config import WavefrontConfig
from sjmc_planner.wavefront_plan import CostMap


def compile_kernels() -> None:
    """Decide once by each method for each kind of drive; compiled code is kept on disk."""
    scan = Scan(np.full(16, 1.0), -np.pi, np.pi / 8, 0.1, 3.0)
    default = LocalPlannerConfig()
    for name in METHODS:
        for drive in ("omni", "differential"):
            config = replace(default, method=name, robot=replace(default.robot, drive=drive))
            for sensor in (SE2.identity(), SE2(0.1, 0.0, 0.0)):
                make_method(config).decide(
                    RobotState(Velocity(0.1, 0.0, 0.0)),
                    Obstacles(scan, sensor, known=np.array([[0.9, 0.0]])),
                    Goal(np.array([2.0, 0.0]), 2.0), has_debug=True,
                )  # fmt: skip


def compile_wavefront() -> None:
    """Plan a way over a small map and look at it again."""
    grid = OccupancyMap(np.zeros((12, 12), dtype=np.int8), 0.1, SE2.identity())
    costs = CostMap(grid, WavefrontConfig())
    way = costs.plan(np.array([0.25, 0.25]), np.array([0.95, 0.95]))
    costs.cost_of(way.points)
