"""How far a robot may have moved from one image to the next."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.motion_config import MotionConfig


def motion_between(
    before: SE2 | None, after: SE2 | None, dt: float, config: MotionConfig
) -> tuple[SE2, np.ndarray]:
    """Return the motion in a time by odometry, or none with the deviation of all that can be."""
    if before is None or after is None:
        share, motion = dt / config.gate_sd, SE2.identity()
        way, turn = config.max_speed_m_s * share, config.max_turn_rad_s * share
    else:
        motion = before.between(after)
        way = config.odom_share * motion.distance
        turn = config.odom_share * abs(motion.yaw)
    sd_m, sd_rad = math.hypot(way, config.slack_m), math.hypot(turn, config.slack_rad)
    return motion, np.diag((sd_m, sd_m, sd_rad)) ** 2
