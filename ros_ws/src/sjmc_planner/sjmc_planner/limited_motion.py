"""Motion under an acceleration limit (floor paper, eq. 10 and 12).

The print of eq. 12 jumps at t_a: its second case must have a minus before dv |dv| / (2 alpha). With
t_a = |dv| / alpha both cases give v_a (t_a + dt) + dv t_a / 2 there, and the motion goes on at v_b.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import Velocity


def limited_velocity(va: np.ndarray, vb: np.ndarray, accel: float, t: float) -> np.ndarray:
    """Return the velocity a time after a command (eq. 10).

    Args:
        va: Velocity when the command came, shape (2,), m/s.
        vb: Velocity commanded, shape (..., 2), m/s.
        accel: Limit of the acceleration's length, m/s^2.
        t: Time since, s.

    Returns:
        Shape (..., 2).
    """
    dv = vb - va
    length = np.linalg.norm(dv, axis=-1, keepdims=True)
    share = np.minimum(1.0, accel * t / np.maximum(length, 1e-12))
    return np.asarray(va + share * dv)


def limited_position(
    va: np.ndarray, vb: np.ndarray, accel: float, idle_time: float, t: np.ndarray | float
) -> np.ndarray:
    """Return where a robot at the origin is a time after a command (eq. 12).

    Args:
        va: Velocity when the command came, shape (2,), m/s.
        vb: Velocity commanded, shape (..., 2), m/s.
        accel: Limit of the acceleration's length, m/s^2.
        idle_time: How long it goes on at `va` before the command acts, s.
        t: Times since then, s, shape (T,) or a number.

    Returns:
        Shape (..., T, 2), or (..., 2) for a number.
    """
    dv = np.expand_dims(vb - va, -2)
    length = np.linalg.norm(dv, axis=-1, keepdims=True)
    ta = length / accel
    time = np.atleast_1d(np.asarray(t, dtype=float))[:, None]
    unit = dv / np.maximum(length, 1e-12)
    rising = va * (time + idle_time) + 0.5 * unit * accel * time**2
    steady = va * idle_time + np.expand_dims(vb, -2) * time - dv * length / (2.0 * accel)
    x = np.where(time < ta, rising, steady)
    return np.asarray(x if np.ndim(t) else x[..., 0, :])


def stopping_speed(distance: float, accel: float, idle_time: float) -> float:
    """Return the speed from which a robot stops within a distance: v dt + v^2 / (2 alpha) = d."""
    return accel * (math.sqrt(idle_time**2 + 2.0 * max(distance, 0.0) / accel) - idle_time)


def held_to(wanted: Velocity, robot: RobotConfig) -> Velocity:
    """Return a velocity held to the robot's fastest travel and turn, on the same arc."""
    share = min(
        1.0,
        robot.speed_m_s / max(wanted.speed, 1e-12),
        robot.yaw_rate_rad_s / max(abs(wanted.yaw_rate), 1e-12),
    )
    return Velocity(share * wanted.x, share * wanted.y, share * wanted.yaw_rate)


def ramped(last: Velocity, wanted: Velocity, robot: RobotConfig, dt: float) -> Velocity:
    """Return the command on the way from the last one to the one wanted, within the limits.

    A holonomic robot's velocity vector changes by eq. 10; of a differential one speed and yaw rate
    change each on its own. What is wanted is `held_to` the limits first.
    """
    wanted = held_to(wanted, robot)
    most = robot.accel_m_s2 * dt
    now, aim = np.array([last.x, last.y]), np.array([wanted.x, wanted.y])
    if robot.drive == "differential":
        x, y = float(now[0] + np.clip(aim[0] - now[0], -most, most)), 0.0
    else:
        x, y = limited_velocity(now, aim, robot.accel_m_s2, dt).tolist()
    turn = robot.yaw_accel_rad_s2 * dt
    yaw_rate = last.yaw_rate + float(np.clip(wanted.yaw_rate - last.yaw_rate, -turn, turn))
    return Velocity(x, y, yaw_rate)


def seen_from(velocity: Velocity, T_base_child: SE2) -> Velocity:
    """Return the base's velocity from that of another frame on the same robot, in its own axes."""
    c, s = math.cos(T_base_child.yaw), math.sin(T_base_child.yaw)
    w = velocity.yaw_rate
    return Velocity(
        c * velocity.x - s * velocity.y + w * T_base_child.y,
        s * velocity.x + c * velocity.y - w * T_base_child.x,
        w,
    )


def moved_by(velocity: Velocity, dt: float) -> SE2:
    """Return where a robot is after a steady motion, seen from where it was."""
    yaw = velocity.yaw_rate * dt
    c, s = float(np.cos(0.5 * yaw)), float(np.sin(0.5 * yaw))
    chord = dt * float(np.sinc(0.5 * yaw / np.pi))
    x, y = velocity.x * chord, velocity.y * chord
    return SE2(c * x - s * y, s * x + c * y, yaw)
