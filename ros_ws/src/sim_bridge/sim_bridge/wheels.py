"""Wheels on a floor: where they slip, what their encoders count, what odometry makes of it.

The encoders count how far a wheel turned; slip and the true radius decide how far the robot came.
Odometry knows only the counts, the believed radius and the track, so it drifts for the reasons a
real one does, and says by how much (`sim_bridge.drift`).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.config import WheelConfig
from sim_bridge.drift import Drift, drift_step, first_drift, pose_cov
from sim_bridge.drive import STOP, Velocity


@dataclass(frozen=True)
class WheelState:
    """All wheels, shape (K,) each: left, right, or those of `bearings_deg`.

    Attributes:
        turned: How far each has turned, rad.
        slip: Deviation of the share of its travel that it loses now.
        radius_error: Relative error of the believed radius, fixed for a run.
    """

    turned: np.ndarray
    slip: np.ndarray
    radius_error: np.ndarray


@dataclass(frozen=True)
class OdometryState:
    """Dead reckoning so far.

    Attributes:
        pose: `T_odom_base`.
        velocity: Over the last interval.
        cov: Mean square error of (x, y, yaw) in the odom frame, (3, 3).
        ticks: Encoder counts (or rad, if exact) at the last update, shape (K,).
        drift: What `cov` is made of.
    """

    pose: SE2
    velocity: Velocity
    cov: np.ndarray
    ticks: np.ndarray
    drift: Drift


def first_wheel_state(config: WheelConfig, rng: np.random.Generator) -> WheelState:
    """Return wheels at rest with the radius errors of this run."""
    num = num_wheels(config)
    errors = config.radius_error_sd * rng.standard_normal(num)
    return WheelState(np.zeros(num), config.slip_sd * rng.standard_normal(num), errors)


def first_odometry(config: WheelConfig) -> OdometryState:
    """Return odometry at its origin."""
    num = num_wheels(config)
    drift = first_drift(config, num)
    return OdometryState(SE2.identity(), STOP, np.zeros((3, 3)), np.zeros(num), drift)


def num_wheels(config: WheelConfig) -> int:
    """Return how many wheels are driven."""
    return len(config.bearings_deg) or 2


def wheel_speeds(config: WheelConfig, base: Velocity) -> np.ndarray:
    """Return how fast each wheel's rim runs at a velocity of the base, shape (K,), m/s."""
    if config.bearings_deg:
        return _omni_matrix(config) @ (base.speed, base.side_speed, base.yaw_rate)
    return base.speed + np.array([-0.5, 0.5]) * config.track_m * base.yaw_rate


def base_velocity(config: WheelConfig, speeds: np.ndarray) -> Velocity:
    """Return the base's velocity from its wheels' (also lengths: the motion from the travel).

    Four and more omnidirectional wheels can contradict each other: least squares then.
    """
    x, y, yaw = motion_matrix(config) @ speeds
    return Velocity(float(x), float(yaw), float(y))


@functools.lru_cache(maxsize=32)
def motion_matrix(config: WheelConfig) -> np.ndarray:
    """Return the base's (forward, left, turn) for each wheel's travel, shape (3, K), 1 and 1/m."""
    if config.bearings_deg:
        return np.asarray(np.linalg.pinv(_omni_matrix(config)))
    return np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / config.track_m, 1.0 / config.track_m]])


@functools.lru_cache(maxsize=32)
def _omni_matrix(config: WheelConfig) -> np.ndarray:
    bearings = np.radians(config.bearings_deg)
    turn = np.full(len(bearings), config.mount_radius_m)
    return np.column_stack((-np.sin(bearings), np.cos(bearings), turn))


def wheels_step(
    config: WheelConfig,
    state: WheelState,
    drive: Velocity,
    dt: float,
    rng: np.random.Generator,
) -> tuple[WheelState, Velocity]:
    """Turn the wheels for `dt`.

    Args:
        config: The wheels.
        state: Before the step.
        drive: What the drive makes of the wheels, as a velocity of the base.
        dt: s.
        rng: Source of the slip, an Ornstein-Uhlenbeck process per wheel.

    Returns:
        The wheels after the step, and the velocity that the floor gives the robot.
    """
    surface_speed = wheel_speeds(config, drive)
    keep = math.exp(-dt / config.slip_time_s)
    fresh = config.slip_sd * math.sqrt(1.0 - keep**2)
    slip = keep * state.slip + fresh * rng.standard_normal(len(state.slip))
    lost = np.clip(config.slip_mean + slip, -0.5, 0.95)
    if config.slip_mean == 0.0 and config.slip_sd == 0.0:
        lost = np.zeros_like(slip)
    ground = surface_speed * (1.0 + state.radius_error) * (1.0 - lost)
    moved = replace(state, turned=state.turned + surface_speed / config.radius_m * dt, slip=slip)
    return moved, base_velocity(config, ground)


def odometry_step(
    wheels: WheelConfig, state: OdometryState, turned: np.ndarray, dt: float
) -> OdometryState:
    """Dead-reckon over an interval.

    Args:
        wheels: Believed radius and track, encoder ticks, and how uncertain they are.
        state: At the last update.
        turned: How far each wheel has turned since the start, (K,), rad.
        dt: Time since the last update, s.
    """
    per_turn = wheels.ticks_per_turn
    ticks = np.floor(turned / (2.0 * np.pi) * per_turn) if per_turn else turned
    unit = 2.0 * np.pi / per_turn if per_turn else 1.0
    travels = (ticks - state.ticks) * unit * wheels.radius_m
    moved = base_velocity(wheels, travels)
    ahead, aside, turn = moved.speed, moved.side_speed, moved.yaw_rate
    # Exact for constant wheel speeds: the chord of the arc, along its middle direction.
    shrunk = float(np.sinc(turn / (2.0 * np.pi)))
    middle = state.pose.yaw + turn / 2.0
    c, s = math.cos(middle), math.sin(middle)
    pose = SE2(
        state.pose.x + shrunk * (ahead * c - aside * s),
        state.pose.y + shrunk * (ahead * s + aside * c),
        state.pose.yaw + turn,
    )
    M = motion_matrix(wheels)
    drift = drift_step(wheels, state.drift, M, travels, middle, dt)
    cov = pose_cov(wheels, drift, M, pose.yaw)
    return OdometryState(pose, Velocity(ahead / dt, turn / dt, aside / dt), cov, ticks, drift)
