"""How far dead reckoning may be off: its mean square error, carried along the way it reports.

What goes wrong is known from the wheels: each has a scale error that lasts for the run (its radius,
and the mean slip, which odometry does not know of), and slip that comes and goes. The errors of
pose, scales and slips are one linear system, whose mean square is carried on exactly, so that what
lasts adds up as the length and what comes and goes as a random walk.

A yaw error t also shortens the way: by t^2 / 2 of each piece of it, which no linear system has and
which is most of the error along a long straight way. Its mean square is carried on too: for a
Gaussian t, E[t_a^2 t_b^2] = E[t_a^2] E[t_b^2] + 2 E[t_a t_b]^2. What stays out is of third order:
the claim holds until the yaw is off by about half a radian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim_bridge.config import WheelConfig


@dataclass(frozen=True)
class Drift:
    """Errors of K wheels' dead reckoning, truth minus reckoned.

    Attributes:
        mean: Of (x, y, yaw, scale of each wheel, slip of each wheel), (3 + 2K,).
        square: Their mean square, (3 + 2K, 3 + 2K).
        lost: Way that is lost by yaw errors on the mean, (2,), m.
        pairs: Sum of pieces of way along x and y, each times g g^T with g the mean product of the
            yaw there and (yaw, scales, slips) now, (2, 1 + 2K, 1 + 2K).
        lost_square: Mean square of the way lost, (2, 2), m^2.
    """

    mean: np.ndarray
    square: np.ndarray
    lost: np.ndarray
    pairs: np.ndarray
    lost_square: np.ndarray


def first_drift(config: WheelConfig, num_wheels: int) -> Drift:
    """Return what is uncertain before the first motion: the wheels, not the pose."""
    size, scales = 3 + 2 * num_wheels, slice(3, 3 + num_wheels)
    mean, square = np.zeros(size), np.zeros((size, size))
    mean[scales] = -config.slip_mean
    square[scales, scales] = config.slip_mean**2 + config.radius_error_sd**2 * np.eye(num_wheels)
    slips = slice(3 + num_wheels, size)
    square[slips, slips] = config.slip_sd**2 * np.eye(num_wheels)
    pairs = np.zeros((2, size - 2, size - 2))
    return Drift(mean, square, np.zeros(2), pairs, np.zeros((2, 2)))


def drift_step(
    config: WheelConfig,
    drift: Drift,
    T_base_wheels: np.ndarray,
    travels: np.ndarray,
    yaw: float,
    dt: float,
) -> Drift:
    """Carry the errors on over a motion that is short beside a turn.

    Args:
        config: The wheels.
        drift: Before the motion.
        T_base_wheels: Motion (forward, left, turn) of the base for travels of the wheels, (3, K).
        travels: Of each wheel, as reckoned, (K,), m.
        yaw: In the middle of the motion, as reckoned.
        dt: Time that it took, s.
    """
    way, F = error_step(T_base_wheels, travels, yaw)
    keep, num = math.exp(-dt / config.slip_time_s), len(travels)
    slips = np.arange(3 + num, 3 + 2 * num)
    F[slips, slips] = keep
    square = F @ drift.square @ F.T
    square[slips, slips] += config.slip_sd**2 * (1.0 - keep**2)
    of_yaw, F_yaw = drift.square[2:, 2], F[2:, 2:]
    # With the pieces before: a quarter of E[t_a^2 t_b^2], summed; with itself: 3/4 of E[t^2]^2.
    var = float(of_yaw[0])
    before = 0.5 * (drift.lost * var + drift.pairs[:, 0, 0])
    crossed = np.outer(way, before)
    lost_square = drift.lost_square + crossed + crossed.T + 0.75 * var**2 * np.outer(way, way)
    pairs = F_yaw @ (drift.pairs + way[:, None, None] * np.outer(of_yaw, of_yaw)) @ F_yaw.T
    return Drift(F @ drift.mean, square, drift.lost + 0.5 * var * way, pairs, lost_square)


def pose_cov(
    config: WheelConfig, drift: Drift, T_base_wheels: np.ndarray, yaw: float
) -> np.ndarray:
    """Return the mean square error of (x, y, yaw) at a reckoned yaw, (3, 3).

    Counts of encoders lag behind by half a tick on the mean and by 1/12 tick^2 at random.
    """
    cov = drift.square[:3, :3].copy()
    # Slip shortens the way too: that and what yaw errors lose have the same sign.
    crossed = np.outer(drift.mean[:2], drift.lost)
    cov[:2, :2] += drift.lost_square - crossed - crossed.T
    if config.ticks_per_turn:
        tick = 2.0 * math.pi * config.radius_m / config.ticks_per_turn
        M = _turned(yaw) @ T_base_wheels
        lag = tick / 2.0 * T_base_wheels.sum(axis=1)
        cov += tick**2 / 12.0 * (M @ M.T) + np.outer(lag, lag)
    return np.asarray(0.5 * (cov + cov.T))


def error_step(
    T_base_wheels: np.ndarray, travels: np.ndarray, yaw: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the way in the odom frame, (2,), and how errors before it act after it."""
    num = len(travels)
    per_wheel = _turned(yaw) @ T_base_wheels * travels
    dx, dy, _ = per_wheel.sum(axis=1)
    # An error of the turn turns the way's direction by half of it.
    per_wheel[:2] += np.outer((-0.5 * dy, 0.5 * dx), per_wheel[2])
    F = np.eye(3 + 2 * num)
    F[:2, 2] = -dy, dx
    F[:3, 3 : 3 + num] = F[:3, 3 + num :] = per_wheel
    return np.array([dx, dy]), F


def _turned(yaw: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
