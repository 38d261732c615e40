"""Two wheels on a floor: where they slip, what their encoders count, what odometry makes of it.

The encoders count how far a wheel turned; slip and the true radius decide how far the robot came.
Odometry knows only the counts, the believed radius and the track, so it drifts for the reasons a
real one does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.config import OdometryConfig, WheelConfig
from sim_bridge.drive import STOP, Velocity


@dataclass(frozen=True)
class WheelState:
    """Both wheels, shape (2,) each: left, right.

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
        cov: Covariance of (x, y, yaw) in the odom frame, (3, 3).
        ticks: Encoder counts (or rad, if exact) at the last update, shape (2,).
    """

    pose: SE2
    velocity: Velocity
    cov: np.ndarray
    ticks: np.ndarray


def first_wheel_state(config: WheelConfig, rng: np.random.Generator) -> WheelState:
    """Return wheels at rest with the radius errors of this run."""
    errors = config.radius_error_sd * rng.standard_normal(2)
    return WheelState(np.zeros(2), config.slip_sd * rng.standard_normal(2), errors)


def first_odometry() -> OdometryState:
    """Return odometry at its origin."""
    return OdometryState(SE2.identity(), STOP, np.zeros((3, 3)), np.zeros(2))


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
    surface_speed = drive.speed + np.array([-0.5, 0.5]) * config.track_m * drive.yaw_rate
    keep = math.exp(-dt / config.slip_time_s)
    fresh = config.slip_sd * math.sqrt(1.0 - keep**2)
    slip = keep * state.slip + fresh * rng.standard_normal(2)
    lost = np.clip(config.slip_mean + slip, -0.5, 0.95)
    if config.slip_mean == 0.0 and config.slip_sd == 0.0:
        lost = np.zeros(2)
    ground = surface_speed * (1.0 + state.radius_error) * (1.0 - lost)
    moved = replace(state, turned=state.turned + surface_speed / config.radius_m * dt, slip=slip)
    yaw_rate = float(ground[1] - ground[0]) / config.track_m
    return moved, Velocity(float(ground.mean()), yaw_rate)


def odometry_step(
    wheels: WheelConfig, config: OdometryConfig, state: OdometryState, turned: np.ndarray, dt: float
) -> OdometryState:
    """Dead-reckon over an interval.

    Args:
        wheels: Believed radius and track, encoder ticks.
        config: The uncertainty to claim.
        state: At the last update.
        turned: How far each wheel has turned since the start, (2,), rad.
        dt: Time since the last update, s.
    """
    per_turn = wheels.ticks_per_turn
    ticks = np.floor(turned / (2.0 * np.pi) * per_turn) if per_turn else turned
    unit = 2.0 * np.pi / per_turn if per_turn else 1.0
    left, right = (ticks - state.ticks) * unit * wheels.radius_m
    travel, turn = float(left + right) / 2.0, float(right - left) / wheels.track_m
    # Exact for constant wheel speeds: the chord of the arc, along its middle direction.
    chord = travel * float(np.sinc(turn / (2.0 * np.pi)))
    middle = state.pose.yaw + turn / 2.0
    pose = SE2(
        state.pose.x + chord * math.cos(middle),
        state.pose.y + chord * math.sin(middle),
        state.pose.yaw + turn,
    )
    cov = _grown_cov(config, state.cov, middle, travel, turn)
    return OdometryState(pose, Velocity(travel / dt, turn / dt), cov, ticks)


def _grown_cov(
    config: OdometryConfig, cov: np.ndarray, yaw: float, travel: float, turn: float
) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    F = np.array([[1.0, 0.0, -travel * s], [0.0, 1.0, travel * c], [0.0, 0.0, 1.0]])
    G = np.array([[c, 0.0], [s, 0.0], [0.0, 1.0]])
    var_travel = config.distance_sd**2 * abs(travel)
    var_turn = config.yaw_sd_per_m**2 * abs(travel) + config.yaw_sd_per_rad**2 * abs(turn)
    return np.asarray(F @ cov @ F.T + G @ np.diag([var_travel, var_turn]) @ G.T)
