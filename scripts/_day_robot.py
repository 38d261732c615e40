"""What planners are told of the robot of a world with goals, on both sides of the comparison."""

from __future__ import annotations

import numpy as np

from experiments.goal_drives import GOAL_LIMIT_S, Pilot
from grid_mapper.config import GridMapperConfig, KeyScanConfig
from sim_bridge.robot_model import RobotModel
from sim_bridge.world import World
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.known_config import KnownConfig
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.wavefront_config import WavefrontConfig

OURS, USUAL = "sjmc", "vfh_plus"
_IDLE_S, _ACCEL = 0.1, 0.6
_MARGIN, _CIRCLE_MARGIN = 0.03, 0.04
_LOOKAHEAD, _TOLERANCE = {OURS: 0.7, USUAL: 1.0}, 0.15
_MAP_AGAIN_S = 1.0
_ROOMS = {"look_m": 1.5, "clearance_m": 0.2}  # rooms are small, and it drives slowly there
# Doors in glass are narrow here: what is heard beside one is not to close it.
_NEAR_ECHOES = {"echo_m": 0.6, "pane_m": 0.1}
_WINDOW_M = 1.2  # with more than that in view VFH+ passes by the doors
_WAY = {"margin_m": 0.04, "near_m": 0.6, "near_weight": 8.0, "unknown_weight": 12.0}


def pilot_of(world: World, model: RobotModel, method: str) -> Pilot:
    """Return what drives: `OURS` by the map with glass, any other by the laser's alone.

    `sjmc` knows the robot's box. VFH+ knows a circle about the wheel axle; one that held the whole
    robot would pass no door, so that it gets the half width and a little more. Of the circles,
    windows and lookaheads tried on the first goal, these took it there soonest, untouched.
    """
    assert world.goals is not None
    corners = np.array(model.config.footprint_m)
    half_width = float(np.abs(corners[:, 1]).max())
    box = {
        "radius_m": float(np.ceil(100.0 * np.hypot(*corners.T).max())) / 100.0,
        "front_m": float(corners[:, 0].max()),
        "rear_m": float(-corners[:, 0].min()),
        "half_width_m": half_width,
    }
    shape = box if method == OURS else {"radius_m": half_width + _CIRCLE_MARGIN}
    robot = RobotConfig(
        drive="differential", margin_m=_MARGIN, speed_m_s=world.goals.speed_m_s,
        accel_m_s2=_ACCEL, idle_time_s=_IDLE_S, **shape,
    )  # fmt: skip
    planner = LocalPlannerConfig(
        method=method, robot=robot, lookahead_m=_LOOKAHEAD[method], goal_tolerance_m=_TOLERANCE,
        sjmc=SjmcConfig(**_ROOMS), histogram=HistogramConfig(window_m=_WINDOW_M),
        known=KnownConfig(**_NEAR_ECHOES),
    )  # fmt: skip
    wavefront = WavefrontConfig(radius_m=half_width + _CIRCLE_MARGIN, **_WAY)
    # A robot that waits maps too, or who has left would stand in its map for good.
    mapper = GridMapperConfig(map_key=KeyScanConfig(period_s=_MAP_AGAIN_S))
    return Pilot(planner, wavefront, mapper, method == OURS, GOAL_LIMIT_S)
