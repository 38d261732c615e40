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


def steady_motion(last: SE2, last_dt: float, dt: float, config: MotionConfig) -> tuple[SE2, np.ndarray]:
    """Predict a motion without odometry: the velocity stays, the acceleration is noise.

    Args:
        last: Motion of the step before.
        last_dt: Time it took, s; 0 if there was none.
        dt: Time to predict for, s.

    Returns:
        The motion and its covariance, shape (3, 3).
    """
    share = dt / last_dt if last_dt > 0.0 else 0.0
    moved = SE2(share * last.x, share * last.y, 0.0 if share == 0.0 else share * last.yaw)
    reach = config.base_m + config.acceleration * dt * dt
    turn = config.base_rad + config.turn_acceleration * dt * dt
    return moved, np.diag([reach, reach, turn]) ** 2


def rotated(cov: np.ndarray, yaw: float) -> np.ndarray:
    """Return a covariance of (x, y, yaw) in axes turned by -yaw: R cov R^T."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return R @ cov @ R.T
