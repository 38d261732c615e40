"""Eq. 10 and 12 against hand-made numbers and against the integral of one in the other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import (
    held_to,
    limited_position,
    limited_velocity,
    moved_by,
    ramped,
    seen_from,
    stopping_speed,
)
from sjmc_planner.planning import STILL, Velocity

TOL = 1e-9
VA = np.array([0.4, 0.0])
SPEEDS = st.floats(-1.0, 1.0)


def test_a_turn_to_the_left_by_hand():
    """v_a = (0.4, 0), v_b = (0, 0.4), alpha = 0.4 sqrt(2): |dv| = 0.4 sqrt(2), t_a = 1 s."""
    vb, accel = np.array([0.0, 0.4]), 0.4 * np.sqrt(2.0)
    assert limited_velocity(VA, vb, accel, 0.5) == pytest.approx([0.2, 0.2])
    x = limited_position(VA, vb, accel, 0.1, np.array([0.0, 1.0, 2.0]))
    # at t = 1: 0.4 (1 + 0.1) - 0.4 / 2 ahead, 0.4 / 2 aside; then 0.4 m/s aside
    assert x == pytest.approx(np.array([[0.04, 0.0], [0.24, 0.2], [0.24, 0.6]]))


def test_both_cases_meet_at_t_a():
    """The printed plus would jump by dv |dv| / alpha there."""
    vb, accel, idle = np.array([-0.2, 0.3]), 0.3, 0.03
    dv = vb - VA
    ta = np.linalg.norm(dv) / accel
    around = limited_position(VA, vb, accel, idle, np.array([ta - 1e-9, ta, ta + 1e-9]))
    assert around[1] == pytest.approx(VA * (ta + idle) + dv * ta / 2.0, abs=TOL)
    assert np.abs(np.diff(around, axis=0)).max() < 1e-8


@given(SPEEDS, SPEEDS, SPEEDS, SPEEDS, st.floats(0.1, 2.0), st.floats(0.0, 4.0))
def test_position_is_the_integral_of_velocity(ax, ay, bx, by, accel, t):
    va, vb = np.array([ax, ay]), np.array([bx, by])
    times = np.linspace(0.0, t, 401)
    v = np.array([limited_velocity(va, vb, accel, s) for s in times])
    area = ((v[1:] + v[:-1]) / 2.0 * np.diff(times)[:, None]).sum(axis=0)
    assert limited_position(va, vb, accel, 0.2, t) == pytest.approx(0.2 * va + area, abs=1e-4)


@given(SPEEDS, SPEEDS, SPEEDS, SPEEDS, st.floats(0.1, 2.0), st.floats(0.0, 1.0))
def test_no_component_of_a_change_beats_the_limit(ax, ay, bx, by, accel, t):
    va = np.array([ax, ay])
    v = limited_velocity(va, np.array([bx, by]), accel, t)
    assert np.linalg.norm(v - va) <= accel * t + TOL


def test_stopping_speed_by_hand():
    """v 0.5 + v^2 / 2 = 1 at 1 m/s^2: v = -0.5 + sqrt(0.25 + 2) = 1."""
    assert stopping_speed(1.0, 1.0, 0.5) == pytest.approx(1.0)
    assert stopping_speed(0.0, 1.0, 0.5) == 0.0
    assert stopping_speed(-1.0, 1.0, 0.5) == 0.0


def test_a_ramp_ends_at_the_command_wanted():
    robot = RobotConfig(accel_m_s2=0.3)
    last = STILL
    for _ in range(8):
        last = ramped(last, Velocity(0.0, 0.1, 0.0), robot, 0.05)
    assert (last.x, last.y) == pytest.approx((0.0, 0.1))
    assert ramped(STILL, Velocity(0.3, 0.4, 0.0), robot, 0.1).speed == pytest.approx(0.03)


def test_a_differential_ramp_has_no_sideways_speed():
    robot = RobotConfig(drive="differential", accel_m_s2=1.0, yaw_accel_rad_s2=2.0)
    sent = ramped(STILL, Velocity(1.0, 1.0, -5.0), robot, 0.1)
    assert (sent.x, sent.y, sent.yaw_rate) == pytest.approx((0.1, 0.0, -0.2))


@given(SPEEDS, SPEEDS, st.floats(-9.0, 9.0))
def test_what_is_held_to_the_limits_is_the_same_arc(x, y, yaw_rate):
    robot, wanted = RobotConfig(speed_m_s=0.4, yaw_rate_rad_s=1.2), Velocity(x, y, yaw_rate)
    held = held_to(wanted, robot)
    assert held.speed <= 0.4 + TOL and abs(held.yaw_rate) <= 1.2 + TOL
    assert held.yaw_rate * wanted.speed == pytest.approx(wanted.yaw_rate * held.speed, abs=1e-9)
    assert held.x * y == pytest.approx(held.y * x, abs=1e-9)
    if wanted.speed <= 0.4 and abs(yaw_rate) <= 1.2:
        assert held == wanted


@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_a_ramp_ends_at_the_limits_whatever_is_wanted(drive):
    """Ten times too fast backward and in the turn: 0.1 of it is both limits at once."""
    robot = RobotConfig(drive=drive, speed_m_s=0.4, yaw_rate_rad_s=1.2)
    last = STILL
    for _ in range(200):
        last = ramped(last, Velocity(-4.0, 0.0, 12.0), robot, 0.05)
    assert (last.x, last.y, last.yaw_rate) == pytest.approx((-0.4, 0.0, 1.2))


def test_a_quarter_turn_of_an_arc():
    """pi/2 m/s at pi/2 rad/s is a circle of 1 m; a second is a quarter of it."""
    pose = moved_by(Velocity(np.pi / 2, 0.0, np.pi / 2), 1.0)
    assert pose.as_array() == pytest.approx([1.0, 1.0, np.pi / 2])


@given(SPEEDS, SPEEDS, SPEEDS, st.floats(0.0, 1.0))
def test_two_halves_of_a_steady_motion_make_the_whole(x, y, w, dt):
    v = Velocity(x, y, w)
    twice = moved_by(v, dt / 2) @ moved_by(v, dt / 2)
    assert isinstance(twice, SE2)
    assert moved_by(v, dt).between(twice).as_array() == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_frame_ahead_that_moves_aside_in_a_turn_belongs_to_a_base_that_turns_on_the_spot():
    """0.5 m ahead and turning at 0.4 rad/s it goes 0.2 m/s to the left; also in turned axes."""
    same = seen_from(Velocity(0.0, 0.2, 0.4), SE2(0.5, 0.0, 0.0))
    turned = seen_from(Velocity(0.2, 0.0, 0.4), SE2(0.5, 0.0, np.pi / 2))
    for found in (same, turned):
        assert (found.x, found.y, found.yaw_rate) == pytest.approx((0.0, 0.0, 0.4), abs=1e-12)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0))
def test_a_velocity_seen_from_another_frame_is_that_frame_s_motion(x, y, yaw, yaw_rate):
    """Moving the base and then looking from the child is the child's own short motion."""
    T, dt = SE2(x, y, yaw), 1e-5
    child = Velocity(0.3, -0.1, yaw_rate)
    moved = T @ moved_by(child, dt) @ T.inverse()
    base = seen_from(child, T)
    assert (moved.x / dt, moved.y / dt) == pytest.approx((base.x, base.y), abs=1e-4)
