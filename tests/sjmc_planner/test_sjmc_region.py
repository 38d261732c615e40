"""The region D that a robot sweeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.planning import Velocity
from sjmc_planner.sjmc_region import Box, box_of, entry_times, free_ways

BOX = Box(front=0.2, rear=0.5, half_width=0.3)
TOL_S = 1e-6
speeds = st.floats(-1.0, 1.0)


def border_of(box: Box) -> np.ndarray:
    corners = box.corners()
    shares = np.linspace(0.0, 1.0, 9)[:, None]
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + shares * (b - a) for a, b in zip(corners, ends, strict=True)])


def test_straight_on_the_front_gets_there_by_the_distance() -> None:
    points = np.array([[1.2, 0.0], [1.2, 0.31], [-1.0, 0.0], [0.1, -0.2]])
    times = entry_times(points, Velocity(0.5, 0.0, 0.0), BOX)
    assert times.tolist() == [2.0, math.inf, math.inf, 0.0]


def test_sideways_the_side_gets_there() -> None:
    times = entry_times(np.array([[0.0, 1.3], [0.3, 1.3]]), Velocity(0.0, 0.5, 0.0), BOX)
    assert times.tolist() == [2.0, math.inf]


def test_turning_on_the_spot_the_rear_corner_sweeps_the_side() -> None:
    """The rear corner is at 210.96 degrees; turning left it gets to -90 degrees 59.04 later."""
    corner = math.hypot(0.5, 0.3)
    point = np.array([[0.0, -(corner - 1e-9)]])
    time = entry_times(point, Velocity(0.0, 0.0, 1.0), BOX)[0]
    assert time == pytest.approx(math.pi / 2.0 - math.atan2(0.3, 0.5), abs=1e-3)


@settings(max_examples=150, deadline=None)
@given(x=speeds, y=speeds, w=st.floats(-2.0, 2.0), t=st.floats(0.0, 2.0))
def test_all_that_the_robot_really_sweeps_is_in_it(x: float, y: float, w: float, t: float) -> None:
    velocity = Velocity(x, y, w)
    swept = moved_by(velocity, t) @ border_of(BOX)
    assert (entry_times(swept, velocity, BOX.grown(1e-6)) <= t + TOL_S).all()


@settings(max_examples=150, deadline=None)
@given(x=speeds, y=speeds, w=st.floats(-2.0, 2.0), px=st.floats(-3.0, 3.0), py=st.floats(-3.0, 3.0))
def test_what_is_in_it_is_in_the_box_at_that_time_and_not_before(
    x: float, y: float, w: float, px: float, py: float
) -> None:
    velocity, point = Velocity(x, y, w), np.array([[px, py]])
    time = float(entry_times(point, velocity, BOX)[0])
    if not math.isfinite(time) or time > 20.0:
        return
    there = (moved_by(velocity, time).inverse() @ point)[0]
    edge = BOX.grown(1e-5)
    assert -edge.rear <= there[0] <= edge.front and abs(there[1]) <= edge.half_width
    inner = BOX.grown(-1e-5)
    for share in (0.0, 0.3, 0.7, 0.99):
        before = (moved_by(velocity, share * time).inverse() @ point)[0]
        is_inside = -inner.rear < before[0] < inner.front and abs(before[1]) < inner.half_width
        assert time == 0.0 or not is_inside


def test_a_robot_without_a_box_is_the_square_around_its_circle() -> None:
    assert box_of(RobotConfig(radius_m=0.3)) == Box(0.3, 0.3, 0.3)
    rectangle = RobotConfig(
        drive="differential", radius_m=0.6, front_m=0.2, rear_m=0.5, half_width_m=0.3
    )
    assert box_of(rectangle) == BOX


def test_a_box_that_its_circle_does_not_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="radius_m must hold the box"):
        RobotConfig(radius_m=0.5, front_m=0.2, rear_m=0.5, half_width_m=0.3)


def test_a_course_is_free_up_to_the_disk_in_its_strip() -> None:
    bearings = np.array([0.0, math.pi / 2.0])
    points, radii = np.array([[2.0, 0.2], [0.4, 3.0]]), np.array([0.0, 0.25])
    free = free_ways(bearings, points, radii, 0.2, 0.3)
    assert free[0] == pytest.approx(1.8)
    assert free[1] == pytest.approx(3.0 - math.sqrt(0.25**2 - 0.1**2) - 0.2)
