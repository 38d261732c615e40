"""Where the robot is expected next, and how wrong that can be."""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import MotionConfig


def odometry_motion(moved: SE2, config: MotionConfig) -> np.ndarray:
    """Return the covariance of a motion that odometry reports, shape (3, 3), in its own axes."""
    along = config.base_m + config.slip * moved.distance
    turn = config.base_rad + config.turn_slip * abs(moved.yaw) + config.turn_per_m * moved.distance
    return np.diag([along, along, turn]) ** 2


def steady_motion(velocity: np.ndarray, dt: float, config: MotionConfig) -> tuple[SE2, np.ndarray]:
    """Predict a motion without odometry: the velocity stays, the acceleration is noise.

    Args:
        velocity: Of (x, y, yaw) in the robot's axes, shape (3,), m/s and rad/s.
        dt: Time to predict for, s.
        config: How fast velocity changes.

    Returns:
        The motion and its covariance, shape (3, 3).
    """
    jitter = config.stamp_jitter_s
    reach = config.base_m + config.acceleration * dt**2 + jitter * np.hypot(*velocity[:2])
    turn = config.base_rad + config.turn_acceleration * dt**2 + jitter * abs(velocity[2])
    return SE2(*(velocity * dt)), np.diag([reach, reach, turn]) ** 2


def updated_velocity(
    velocity: np.ndarray, moved: SE2, dt: float, config: MotionConfig
) -> np.ndarray:
    """Return the velocity after a step, smoothed: stamps of single scans are not to be trusted.

    Args:
        velocity: Before the step, shape (3,), m/s and rad/s.
        moved: The step.
        dt: Time it took by the stamps, s.
        config: Over which time to smooth.
    """
    return velocity + (moved.as_array() - velocity * dt) / (dt + config.smoothing_s)


def rotated(cov: np.ndarray, yaw: float) -> np.ndarray:
    """Return a covariance of (x, y, yaw) in axes turned by -yaw: R cov R^T."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return R @ cov @ R.T
