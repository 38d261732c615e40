"""Wheels and dead reckoning: known arcs, quantisation, slip, covariance."""

import math

import numpy as np
import pytest

from sim_bridge.config import OdometryConfig, WheelConfig
from sim_bridge.drive import Velocity
from sim_bridge.wheels import first_odometry, first_wheel_state, odometry_step, wheels_step

EXACT = WheelConfig(ticks_per_turn=0, radius_error_sd=0.0, slip_mean=0.0, slip_sd=0.0)


def _turned(left_m: float, right_m: float) -> np.ndarray:
    return np.array([left_m, right_m]) / EXACT.radius_m


def test_a_quarter_circle_ends_where_it_should() -> None:
    radius = 2.0
    arc = math.pi / 2.0
    turned = _turned((radius - 0.25) * arc, (radius + 0.25) * arc)
    pose = odometry_step(EXACT, OdometryConfig(), first_odometry(), turned, 1.0).pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((2.0, 2.0, math.pi / 2.0))


def test_quantised_odometry_is_within_a_tick() -> None:
    coarse = WheelConfig(ticks_per_turn=100)
    state = odometry_step(coarse, OdometryConfig(), first_odometry(), _turned(1.0, 1.0), 1.0)
    tick = 2.0 * math.pi * coarse.radius_m / 100
    assert 1.0 - tick < state.pose.x <= 1.0 and state.pose.x != 1.0


def test_wheels_without_slip_move_the_robot_as_they_turn() -> None:
    rng = np.random.default_rng(0)
    state, velocity = wheels_step(
        EXACT, first_wheel_state(EXACT, rng), Velocity(1.0, 0.4), 0.1, rng
    )
    assert (velocity.speed, velocity.yaw_rate) == pytest.approx((1.0, 0.4))
    assert state.turned == pytest.approx(_turned(0.09, 0.11))


def test_mean_slip_shortens_the_way() -> None:
    config = WheelConfig(radius_error_sd=0.0, slip_mean=0.1, slip_sd=0.02)
    rng = np.random.default_rng(0)
    state, way = first_wheel_state(config, rng), 0.0
    for _ in range(20000):
        state, velocity = wheels_step(config, state, Velocity(1.0, 0.0), 0.01, rng)
        way += velocity.speed * 0.01
    assert way / 200.0 == pytest.approx(0.9, abs=0.003)


def test_covariance_grows_and_stays_symmetric() -> None:
    state, traces = first_odometry(), []
    for k in range(1, 50):
        state = odometry_step(EXACT, OdometryConfig(), state, _turned(0.1 * k, 0.11 * k), 0.02)
        traces.append(np.trace(state.cov))
    assert np.all(np.diff(traces) > 0.0)
    assert np.allclose(state.cov, state.cov.T) and np.linalg.eigvalsh(state.cov).min() > -1e-12
