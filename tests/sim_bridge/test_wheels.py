"""Wheels and dead reckoning: known arcs, quantisation, slip, covariance."""

import math

import numpy as np
import pytest

from sim_bridge.config import WheelConfig
from sim_bridge.drive import Velocity
from sim_bridge.wheels import (
    base_velocity,
    first_odometry,
    first_wheel_state,
    odometry_step,
    wheel_speeds,
    wheels_step,
)

EXACT = WheelConfig(ticks_per_turn=0, radius_error_sd=0.0, slip_mean=0.0, slip_sd=0.0)


def _turned(left_m: float, right_m: float) -> np.ndarray:
    return np.array([left_m, right_m]) / EXACT.radius_m


def test_a_quarter_circle_ends_where_it_should() -> None:
    radius = 2.0
    arc = math.pi / 2.0
    turned = _turned((radius - 0.25) * arc, (radius + 0.25) * arc)
    pose = odometry_step(EXACT, first_odometry(EXACT), turned, 1.0).pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((2.0, 2.0, math.pi / 2.0))


def test_quantised_odometry_is_within_a_tick() -> None:
    coarse = WheelConfig(ticks_per_turn=100)
    state = odometry_step(coarse, first_odometry(EXACT), _turned(1.0, 1.0), 1.0)
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
    config = WheelConfig(ticks_per_turn=0)
    state, traces = first_odometry(config), []
    for k in range(1, 50):
        state = odometry_step(config, state, _turned(0.1 * k, 0.11 * k), 0.02)
        traces.append(np.trace(state.cov))
    assert np.all(np.diff(traces) > 0.0)
    assert np.allclose(state.cov, state.cov.T) and np.linalg.eigvalsh(state.cov).min() > -1e-12


def test_wheels_without_errors_claim_none() -> None:
    state = odometry_step(EXACT, first_odometry(EXACT), _turned(1.0, 1.1), 1.0)
    assert np.array_equal(state.cov, np.zeros((3, 3)))


def test_a_larger_wheel_than_believed_goes_farther_than_counted() -> None:
    rng = np.random.default_rng(5)
    config = WheelConfig(slip_mean=0.0, slip_sd=0.0, radius_error_sd=0.1)
    state = first_wheel_state(config, rng)
    assert np.abs(state.radius_error).min() > 0.005
    state, velocity = wheels_step(config, state, Velocity(1.0, 0.0), 0.1, rng)
    left, right = 1.0 + state.radius_error
    assert velocity.speed == pytest.approx((left + right) / 2.0)
    assert velocity.yaw_rate == pytest.approx((right - left) / config.track_m)
    assert state.turned == pytest.approx([0.1 / config.radius_m] * 2)


OMNI = WheelConfig(
    bearings_deg=(60.0, 180.0, 300.0), ticks_per_turn=0, radius_error_sd=0.0, slip_mean=0.0,
    slip_sd=0.0, mount_radius_m=0.07, radius_m=0.025,
)  # fmt: skip


def test_omnidirectional_wheels_run_as_computed_by_hand() -> None:
    # Wheel at 180 deg drives along -y; forward motion turns the other two against each other.
    assert wheel_speeds(OMNI, Velocity(0.0, 0.0, 0.4)) == pytest.approx([0.2, -0.4, 0.2])
    side = 0.4 * math.sqrt(0.75)
    assert wheel_speeds(OMNI, Velocity(0.4, 0.0)) == pytest.approx([-side, 0.0, side])
    assert wheel_speeds(OMNI, Velocity(0.0, 2.0)) == pytest.approx([0.14] * 3)


@pytest.mark.parametrize("config", [EXACT, OMNI])
def test_base_and_wheel_speeds_are_inverse(config: WheelConfig) -> None:
    base = Velocity(0.3, -0.7, 0.2 if config is OMNI else 0.0)
    again = base_velocity(config, wheel_speeds(config, base))
    assert (again.speed, again.yaw_rate, again.side_speed) == pytest.approx(
        (base.speed, base.yaw_rate, base.side_speed)
    )


def test_an_omnidirectional_arc_ends_where_it_should() -> None:
    # Sideways all the time while turning a quarter: the arc of a circle of radius v / w.
    travel, turn = 1.0, math.pi / 2.0
    turned = wheel_speeds(OMNI, Velocity(0.0, turn, travel)) / OMNI.radius_m
    state = odometry_step(OMNI, first_odometry(OMNI), turned, 1.0)
    radius = travel / turn
    assert (state.pose.x, state.pose.y) == pytest.approx((-radius, radius))
    assert state.pose.yaw == pytest.approx(turn)
    assert state.velocity.side_speed == pytest.approx(travel)
