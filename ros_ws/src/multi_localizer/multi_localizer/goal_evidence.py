"""What a goal that is seen says about a pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.floor_node_config import FloorTrackConfig


@dataclass(frozen=True, eq=False)
class GoalsSeen:
    """Bearings of one class of goal at one moment.

    Attributes:
        kind: The class.
        stamp_ns: The moment.
        bearings: In the sensor's frame, largest first, (K,), rad.
        T_base_sensor: Where the sensor is.
    """

    kind: str
    stamp_ns: int
    bearings: np.ndarray
    T_base_sensor: SE2


def goal_likelihood(
    pose: SE2, bearings: np.ndarray, goal: tuple[float, float], config: FloorTrackConfig
) -> float:
    """Return how likely bearings, (K,), are from the sensor's pose: any of them may be the goal."""
    true = math.atan2(goal[1] - pose.y, goal[0] - pose.x) - pose.yaw
    off = np.array([wrap_angle(true - float(b)) for b in bearings])
    sd = config.goal_sd_rad
    right = np.exp(-0.5 * (off / sd) ** 2).mean() / (math.sqrt(2.0 * math.pi) * sd)
    share = config.false_goal_share
    return float(share / (2.0 * math.pi) + (1.0 - share) * right)
