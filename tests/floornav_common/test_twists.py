"""Steady motion in the plane: by hand, and as the laws of the exponential map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from floornav_common.twists import steady_offsets, twist_between, twist_of_mounted

TOL = 1e-9
speeds, turns, ways = st.floats(-3.0, 3.0), st.floats(-3.1, 3.1), st.floats(-5.0, 5.0)
twists = st.tuples(speeds, speeds, speeds)
poses = st.builds(SE2, ways, ways, turns)


def moved(twist, t: float) -> SE2:
    x, y = steady_offsets(twist, np.array([t]))[0]
    return SE2(x, y, twist[2] * t)


def test_a_quarter_of_a_circle_by_hand():
    # pi / 2 m and a quarter of a turn in a second: a circle of radius 1 round (0, 1).
    twist = (np.pi / 2.0, 0.0, np.pi / 2.0)
    offsets = steady_offsets(twist, np.array([0.0, 1.0, 2.0, -1.0]))
    assert offsets == pytest.approx(np.array([[0, 0], [1, 1], [0, 2], [-1, 1]]), abs=TOL)
    assert twist_between(SE2(1.0, 1.0, np.pi / 2.0), 1.0) == pytest.approx(twist)


def test_without_a_turn_the_way_is_straight():
    offsets = steady_offsets((2.0, -1.0, 0.0), np.array([0.5]))
    assert offsets == pytest.approx(np.array([[1.0, -0.5]]))
    assert twist_between(SE2(1.0, -0.5, 0.0), 0.5) == pytest.approx((2.0, -1.0, 0.0))


def test_a_sensor_ahead_of_a_turning_base_moves_sideways():
    assert twist_of_mounted((0.0, 0.0, 2.0), SE2(0.5, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 2.0))
    assert twist_of_mounted((1.0, 0.0, 0.0), SE2(0.5, 0.2, np.pi / 2.0)) == pytest.approx(
        (0.0, -1.0, 0.0)
    )


@given(poses, st.floats(0.01, 2.0))
def test_the_twist_of_a_motion_leads_there(pose, dt):
    back = moved(twist_between(pose, dt), dt)
    assert back.as_array() == pytest.approx(pose.as_array(), abs=1e-6)


@given(twists, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_times_add_up(twist, a, b):
    both, one = moved(twist, a) @ moved(twist, b), moved(twist, a + b)
    assert both.between(one).as_array() == pytest.approx(np.zeros(3), abs=TOL)


@given(twists, poses, st.floats(-1.0, 1.0))
def test_what_is_mounted_moves_with_its_base(twist, mount, t):
    by_base = mount.inverse() @ moved(twist, t) @ mount
    own = moved(twist_of_mounted(twist, mount), t)
    assert by_base.between(own).as_array() == pytest.approx(np.zeros(3), abs=1e-8)


@given(twists)
def test_it_begins_with_its_velocity(twist):
    h = 1e-6
    slope = (moved(twist, h).as_array() - moved(twist, -h).as_array()) / (2.0 * h)
    assert slope == pytest.approx(np.array(twist), abs=1e-5)


def test_no_time_has_no_twist():
    with pytest.raises(ValueError, match="dt must be > 0"):
        twist_between(SE2.identity(), 0.0)
