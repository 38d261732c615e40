"""What the localizer holds of the last scan, and the motion since then by odometry or without."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import MotionConfig
from grid_mapper.motion import odometry_motion, rotated, steady_motion

RESET_SLACK_S = 0.5  # logs stamp scans that badly
ON_M, ON_RAD = 0.5, 0.5
"""What odometry may move by while time jumps: scans and transforms are missing for a moment."""


@dataclass(frozen=True)
class Step:
    """State after a scan, from which the next is predicted.

    `cov` is that of the pose in the map; `cov_near` counts only what came since the last trusted
    scan, for the map round the robot was made by poses that share all error before that.
    """

    stamp_ns: int
    T_map_base: SE2
    T_odom_base: SE2 | None
    cov: np.ndarray
    cov_near: np.ndarray
    velocity: np.ndarray


def is_reset(
    last: Step | None, stamp_ns: int, T_odom_base: SE2 | None, config: MotionConfig
) -> bool:
    """Tell whether odometry jumped by more than a robot can move."""
    if T_odom_base is None or last is None or last.T_odom_base is None:
        return False
    return has_jumped(last.stamp_ns, last.T_odom_base, stamp_ns, T_odom_base, config)


def has_jumped(
    last_ns: int, T_odom_last: SE2, stamp_ns: int, T_odom_base: SE2, config: MotionConfig
) -> bool:
    """Tell whether two poses by odometry are further apart than a robot can move."""
    moved = T_odom_last.between(T_odom_base)
    dt = abs(stamp_ns - last_ns) * 1e-9 + RESET_SLACK_S
    return moved.distance > config.max_speed * dt or abs(moved.yaw) > config.max_turn_rate * dt


def goes_on(T_odom_last: SE2, T_odom_base: SE2) -> bool:
    """Tell whether odometry goes on over a jump of time: only the clock was set, nobody carried it.

    A recording that begins again, or another one, has its odometry elsewhere.
    """
    moved = T_odom_last.between(T_odom_base)
    return moved.distance <= ON_M and abs(moved.yaw) <= ON_RAD


class OdometryWatch:
    """Tells when odometry jumps from one scan to the next, or over a jump of time.

    Attributes:
        has_time_jumped: Whether time did since the last odometry.
    """

    def __init__(self) -> None:
        self._last: tuple[int, SE2] | None = None
        self.has_time_jumped = False

    def break_time(self) -> None:
        """Take note that time jumped."""
        self.has_time_jumped = True

    def take(self, stamp_ns: int, T_odom_base: SE2 | None, config: MotionConfig) -> bool:
        """Take odometry at a scan; None where there is none."""
        if T_odom_base is None and self.has_time_jumped:
            return False
        last, has_time_jumped = self._last, self.has_time_jumped
        self._last = None if T_odom_base is None else (stamp_ns, T_odom_base)
        self.has_time_jumped = False
        if T_odom_base is None or last is None:
            return has_time_jumped
        if has_time_jumped:
            return not goes_on(last[1], T_odom_base)
        return has_jumped(*last, stamp_ns, T_odom_base, config)


def motion_since(
    last: Step | None, stamp_ns: int, T_odom_base: SE2 | None, config: MotionConfig
) -> tuple[SE2, np.ndarray, float]:
    """Return the motion since the last scan, its covariance in map axes, the time passed."""
    if last is None:
        return SE2.identity(), np.zeros((3, 3)), 0.0
    dt = max(0.0, (stamp_ns - last.stamp_ns) * 1e-9)
    if T_odom_base is not None and last.T_odom_base is not None:
        moved = last.T_odom_base.between(T_odom_base)
        cov = odometry_motion(moved, config)
    else:
        moved, cov = steady_motion(last.velocity, dt, config)
    return moved, rotated(cov, last.T_map_base.yaw), dt
