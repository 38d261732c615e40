"""How far lines and arcs are free: by hand, and against a way walked in small steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjmc_planner.config import RobotConfig
from sjmc_planner.free_way import can_stop, free_way
from sjmc_planner.planning import Velocity

ROBOT = RobotConfig(drive="differential", radius_m=0.3, margin_m=0.0, accel_m_s2=1.0, speed_m_s=2.0)


def way(points, bearing=0.0, curvature=0.0, radius=0.5, until=10.0):
    return free_way(np.array(points, dtype=float).reshape(-1, 2), bearing, curvature, radius, until)


def test_straight_ways_by_hand():
    assert way([(2.0, 0.0)]) == pytest.approx(1.5)
    assert way([(2.0, 0.3)]) == pytest.approx(1.6)  # 0.4 before it: 0.3, 0.4, 0.5
    assert way([(2.0, 0.5)]) == math.inf and way([(-2.0, 0.0)]) == math.inf
    assert way([(0.0, 3.0), (0.0, 2.0)], bearing=math.pi / 2) == pytest.approx(1.5)
    assert way([(2.0, 0.0)], until=1.4) == math.inf


def test_a_point_within_the_radius_stops_the_way_to_it_and_not_the_way_from_it():
    assert way([(0.3, 0.1)]) == 0.0
    assert way([(-0.3, 0.1)]) == math.inf


def test_an_arc_by_hand():
    """A quarter of a circle of 1 m about (0, 1) leads to (1, 1); a point at 1.5 m from there
    along the same circle's radius is missed, one on the circle is met on the way."""
    assert way([(2.6, 1.0)], curvature=1.0) == math.inf
    met = way([(1.0, 1.0)], curvature=1.0, radius=0.5)
    # chord of 0.5 m on a circle of 1 m: 2 asin(0.25) before the quarter
    assert met == pytest.approx(math.pi / 2 - 2.0 * math.asin(0.25))
    assert way([(1.0, -1.0)], curvature=-1.0) == pytest.approx(met)


@settings(max_examples=60)
@given(
    st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
)  # fmt: skip
def test_ways_against_small_steps(point, bearing, curvature):
    if math.hypot(*point) < 0.55:
        return
    s = np.linspace(0.0, 4.0, 4001)
    half = 0.5 * curvature * s
    chord = s * np.sinc(half / np.pi)
    x, y = chord * np.cos(bearing + half), chord * np.sin(bearing + half)
    near = np.flatnonzero(np.hypot(x - point[0], y - point[1]) < 0.5)
    walked = s[near[0]] if len(near) else math.inf
    found = way([point], bearing, curvature, 0.5, 4.0)
    # A way that just grazes the point may be told either way.
    least = np.hypot(x - point[0], y - point[1]).min()
    if abs(least - 0.5) > 1e-3:
        assert found == pytest.approx(walked, abs=2e-3)


def test_it_can_stop_just_before_what_it_brakes_for():
    """1 m/s at 1 m/s^2 after 0.1 s: 0.1 + 0.5 m, and 0.3 m of robot."""
    velocity = Velocity(1.0, 0.0, 0.0)
    for x, is_enough in ((0.91, True), (0.89, False)):
        assert can_stop(velocity, ROBOT, 0.1, np.array([[x, 0.0]]), 10.0) == is_enough


def test_it_brakes_within_what_was_looked_at():
    nothing = np.zeros((0, 2))
    for horizon, is_enough in ((0.91, True), (0.89, False)):
        assert can_stop(Velocity(1.0, 0.0, 0.0), ROBOT, 0.1, nothing, horizon) == is_enough


def test_a_robot_that_stands_or_turns_on_the_spot_can_stop():
    touching = np.array([[0.2, 0.0]])
    assert can_stop(Velocity(0.0, 0.0, 1.0), ROBOT, 0.1, touching, 10.0)


def test_backward_it_looks_behind():
    behind = np.array([[-0.5, 0.0]])
    assert not can_stop(Velocity(-1.0, 0.0, 0.0), ROBOT, 0.1, behind, 10.0)
    assert can_stop(Velocity(1.0, 0.0, 0.0), ROBOT, 0.1, behind, 10.0)
