"""Sonar readings and odometry without ROS: what Range and Odometry carry, in the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2


@dataclass(frozen=True)
class RangeReading:
    """One echo of a sonar or an infrared sensor, along the x axis of its frame (REP 117).

    Attributes:
        range: m; `+inf` nothing within reach, `-inf` too near, NaN not measured.
        field_of_view: Full opening angle of the cone, rad.
        min_range: Shortest range that is a measurement, m.
        max_range: Longest range that is a measurement, m.
    """

    range: float
    field_of_view: float
    min_range: float
    max_range: float

    @property
    def is_hit(self) -> bool:
        """Whether an obstacle was measured; the far end of the range counts as nothing seen."""
        return math.isfinite(self.range) and self.min_range <= self.range < self.max_range


@dataclass(frozen=True)
class OdometryReading:
    """Where the odometry has the robot, and how it moves.

    Attributes:
        T_odom_base: Pose of the robot in the odometry frame.
        twist: (forward speed, sideways speed, yaw rate) in the robot's frame; m/s, m/s, rad/s.
        pose_cov: Of (x, y, yaw) in the odometry frame, shape (3, 3).
        twist_cov: Of the twist, shape (3, 3).
    """

    T_odom_base: SE2
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pose_cov: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    twist_cov: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
