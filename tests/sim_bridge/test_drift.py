"""What odometry claims about its error: by hand, against differences, and over many runs."""

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.config import WheelConfig
from sim_bridge.drive import Velocity
from sim_bridge.robot_model import load_robot
from sim_bridge.wheels import (
    OdometryState,
    first_odometry,
    first_wheel_state,
    num_wheels,
    odometry_step,
    wheel_speeds,
    wheels_step,
)
from sim_bridge.world import RobotPlacement

DT = 0.02
BEARINGS = (60.0, 180.0, 300.0)
CURVE = Velocity(0.5, 0.4, 0.2)


def _reckoned(config: WheelConfig, velocity: Velocity, steps: int, scales=1.0) -> OdometryState:
    """Return odometry after a steady motion without any error but `scales` of the counts."""
    state, per_step = first_odometry(config), wheel_speeds(config, velocity) / config.radius_m * DT
    for k in range(1, steps + 1):
        state = odometry_step(config, state, k * per_step * scales, DT)
    return state


def test_a_radius_error_on_a_straight_way_by_hand() -> None:
    config = WheelConfig(ticks_per_turn=0, radius_error_sd=1e-6, slip_mean=0.0, slip_sd=0.0)
    cov = _reckoned(config, Velocity(1.0, 0.0), 500).cov  # 10 m
    # Each wheel is off by 10 um: x by half their sum, yaw by their difference over the track.
    assert cov[0, 0] == pytest.approx(1e-10 / 2.0, rel=1e-3)
    assert cov[2, 2] == pytest.approx(2e-10 / 0.5**2)
    assert cov[1, 1] == pytest.approx(cov[2, 2] * 5.0**2)  # an arc ends L / 2 x turn aside
    assert cov[1, 2] == pytest.approx(cov[2, 2] * 5.0)


def test_slip_that_comes_and_goes_adds_up_as_a_random_walk() -> None:
    config = WheelConfig(ticks_per_turn=0, radius_error_sd=0.0, slip_mean=0.0, slip_sd=1e-5)
    cov = _reckoned(config, Velocity(1.0, 0.0), 500).cov
    # Integral of an Ornstein-Uhlenbeck process over 10 s, tau 0.5 s.
    walk = 1e-10 * (2.0 * 0.5 * 10.0 - 2.0 * 0.25 * (1.0 - math.exp(-20.0)))
    assert cov[0, 0] == pytest.approx(walk / 2.0, rel=0.01)
    assert cov[2, 2] == pytest.approx(2.0 * walk / 0.25, rel=0.01)


@pytest.mark.parametrize("bearings", [(), BEARINGS])
def test_scale_errors_spread_as_differences_of_the_way_say(bearings) -> None:
    config = WheelConfig(
        bearings_deg=bearings, ticks_per_turn=0, radius_error_sd=1e-5, slip_mean=0.0, slip_sd=0.0
    )
    velocity = CURVE if bearings else Velocity(CURVE.speed, CURVE.yaw_rate)
    plain = _reckoned(config, velocity, 400)
    columns = []
    for scales in 1.0 + 1e-5 * np.eye(num_wheels(config)):
        off = _reckoned(config, velocity, 400, scales).pose
        columns.append((off.as_array() - plain.pose.as_array()) / 1e-5)
    J = np.array(columns).T
    assert np.allclose(plain.cov, 1e-10 * J @ J.T, rtol=2e-3, atol=1e-14)


def test_what_yaw_errors_lose_of_a_way_is_claimed_by_hand() -> None:
    """A turn that grows as s of the way, s of deviation S: the way is shortened by s^2 L^3 / 6."""
    config = WheelConfig(
        ticks_per_turn=0, radius_error_sd=0.002, slip_mean=0.0, slip_sd=0.0, track_m=0.5
    )
    length = 50.0
    cov = _reckoned(config, Velocity(1.0, 0.0), 2500).cov
    S = 0.002 * math.sqrt(2.0) / 0.5
    lost_square = 3.0 * S**4 * length**6 / 36.0
    assert cov[0, 0] == pytest.approx(lost_square + (0.002 * length) ** 2 / 2.0, rel=0.01)


def test_the_claim_turns_with_the_way() -> None:
    config = WheelConfig(ticks_per_turn=0)
    ahead = _reckoned(config, Velocity(1.0, 0.0), 200)
    quarter = first_odometry(config)
    turn = np.array([-0.25, 0.25]) * math.pi / 2.0 / config.radius_m
    quarter = odometry_step(config, quarter, turn, 1e9)  # so slowly that no slip lasts
    per_step = wheel_speeds(config, Velocity(1.0, 0.0)) / config.radius_m * DT
    for k in range(1, 201):
        quarter = odometry_step(config, quarter, turn + k * per_step, DT)
    assert quarter.pose.y == pytest.approx(4.0)
    # The turn itself adds an error of the yaw, which both share then.
    assert quarter.cov[0, 0] > ahead.cov[1, 1] and quarter.cov[1, 1] >= ahead.cov[0, 0]


def _true_step(pose: SE2, velocity: Velocity) -> SE2:
    turn = velocity.yaw_rate * DT
    shrunk = DT * float(np.sinc(turn / (2.0 * np.pi)))
    c, s = math.cos(pose.yaw + turn / 2.0), math.sin(pose.yaw + turn / 2.0)
    ahead, aside = shrunk * velocity.speed, shrunk * velocity.side_speed
    return SE2(pose.x + ahead * c - aside * s, pose.y + ahead * s + aside * c, pose.yaw + turn)


def _nees(config: WheelConfig, velocity: Velocity, steps: int, seed: int) -> float:
    """Return e^T cov^-1 e of one run; its mean is 3 if the claim is right."""
    rng = np.random.default_rng(seed)
    wheels, odometry = first_wheel_state(config, rng), first_odometry(config)
    truth = SE2.identity()
    for _ in range(steps):
        wheels, over_floor = wheels_step(config, wheels, velocity, DT, rng)
        truth = _true_step(truth, over_floor)
        odometry = odometry_step(config, odometry, wheels.turned, DT)
    off = truth.as_array() - odometry.pose.as_array()
    off[2] = math.remainder(off[2], 2.0 * math.pi)
    return float(off @ np.linalg.solve(odometry.cov, off))


RUNS = 16
# The mean of 16 chi-square values of 3 degrees of freedom: 3, deviation 0.6.
LOW, HIGH = 1.3, 5.2


@pytest.mark.parametrize(
    ("model", "velocity", "steps"),
    [
        ("segway_rmp50", Velocity(0.8, 0.0), 25),
        ("segway_rmp50", Velocity(0.8, 0.0), 600),
        ("segway_rmp50", Velocity(-0.8, 0.0), 400),
        ("segway_rmp50", Velocity(0.0, 1.5), 500),
        ("segway_urg", Velocity(0.6, 0.9), 300),
        ("segway_stereo", Velocity(0.6, -0.3), 300),
        ("soccer_small_size", Velocity(0.4, 0.0), 500),
        ("soccer_small_size", Velocity(0.0, 0.0, 0.4), 500),
        ("soccer_small_size", Velocity(0.0, 1.5), 300),
        ("soccer_middle_size", Velocity(1.0, 0.0), 400),
        ("soccer_middle_size", Velocity(0.0, 0.0, -1.0), 300),
        ("soccer_middle_size", Velocity(0.7, 0.5, 0.3), 300),
    ],
)
def test_odometry_is_off_as_far_as_it_claims(model: str, velocity: Velocity, steps: int) -> None:
    config = load_robot(RobotPlacement(model=model, position_m=(0.0, 0.0))).config.wheels
    mean = np.mean([_nees(config, velocity, steps, seed) for seed in range(RUNS)])
    assert LOW < mean < HIGH
