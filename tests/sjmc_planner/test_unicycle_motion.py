"""Ways of a differential robot: limits, symmetry, where they end."""

from __future__ import annotations

import numpy as np
import pytest

from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import STILL, Velocity
from sjmc_planner.unicycle_motion import Unicycle

ROBOT = RobotConfig(drive="differential", idle_time_s=0.1)
N = 360
T = np.arange(0.0, 4.0, 0.05)


def test_straight_ahead_from_rest_by_hand():
    """0.3 m/s^2 for 4/3 s, then 0.4 m/s."""
    (way,) = Unicycle(ROBOT).ways(STILL, np.array([0.0]), 0.4, T)
    expected = np.where(T < 4 / 3, 0.15 * T**2, 0.8 / 3 + 0.4 * (T - 4 / 3))
    assert way[:, 0] == pytest.approx(expected, abs=1e-3)
    assert way[:, 1] == pytest.approx(0.0)


def test_the_idle_time_goes_on_as_before():
    (way,) = Unicycle(ROBOT).ways(Velocity(0.4, 0.0, 0.5), np.array([2.0]), 0.4, T)
    assert way[0] == pytest.approx([0.04 * np.cos(0.025), 0.04 * np.sin(0.025)])


def test_every_way_ends_in_its_direction():
    bearings = np.array([-2.5, -1.0, 0.0, 0.7, 2.0])
    for bearing, way in zip(
        bearings, Unicycle(ROBOT).ways(STILL, bearings, 0.4, 2 * T), strict=True
    ):
        leg = way[-1] - way[-2]
        assert np.arctan2(leg[1], leg[0]) == pytest.approx(bearing, abs=0.05)


def test_left_and_right_are_mirror_images():
    ways = Unicycle(ROBOT).ways(Velocity(0.3, 0.0, 0.0), np.array([0.9, -0.9]), 0.4, T)
    assert ways[0] * (1.0, -1.0) == pytest.approx(ways[1])


def test_it_turns_on_the_spot_for_what_is_behind():
    command = Unicycle(ROBOT).command(2.5, 0.4)
    assert command.x == 0.0 and command.yaw_rate == pytest.approx(1.2)


def test_a_wall_ahead_is_met_when_the_way_meets_it():
    bearings = 2.0 * np.pi * np.arange(N) / N
    with np.errstate(divide="ignore"):
        table = np.where(np.cos(bearings) > 1e-6, 1.0 / np.cos(bearings), np.inf)
    times = Unicycle(ROBOT).free_times(
        Velocity(0.4, 0.0, 0.0), np.array([0.0, np.pi]), 0.4, 0.01, 6.0, table
    )
    assert times[0] == pytest.approx((1.0 - 0.04) / 0.4, abs=0.011) and times[1] == np.inf


def test_only_what_can_be_stopped_is_taken():
    bearings = 2.0 * np.pi * np.arange(N) / N
    with np.errstate(divide="ignore"):
        near = np.where(np.cos(bearings) > 1e-6, 0.2 / np.cos(bearings), np.inf)
    order = np.array([0, 1])
    unicycle, fast = Unicycle(ROBOT), Velocity(0.4, 0.0, 0.0)
    assert unicycle.first_stoppable(order, fast, np.array([0.0, 0.1]), 0.4, 0.05, near) == -1
    assert unicycle.first_stoppable(order, STILL, np.array([0.0, 0.1]), 0.4, 0.05, near) == 0
