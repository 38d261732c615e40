"""The region D that a robot sweeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.sjmc_region import Box, box_of, free_ways

BOX = Box(front=0.2, rear=0.5, half_width=0.3)
TOL_M = 1e-6
SHARES = np.array([0.0, 0.3, 0.7, 0.99, 1.0])
courses_, places = st.floats(-math.pi, math.pi), st.floats(-3.0, 3.0)


def border_of(box: Box) -> np.ndarray:
    corners = box.corners()
    shares = np.linspace(0.0, 1.0, 9)[:, None]
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + shares * (b - a) for a, b in zip(corners, ends, strict=True)])


def gap_of(point: np.ndarray) -> float:
    """Return how far a point, shape (1, 2), is from the box."""
    x, y = point[0]
    ahead, aside = max(x - BOX.front, -BOX.rear - x, 0.0), max(abs(y) - BOX.half_width, 0.0)
    return math.hypot(ahead, aside)


def box_at(course: float, ways: np.ndarray) -> list[SE2]:
    """Return the poses of a robot that drives straight on along a course."""
    return [SE2(way * math.cos(course), way * math.sin(course), course) for way in ways]


@settings(max_examples=150)
@given(course=courses_, way=st.floats(0.0, 3.0))
def test_all_that_the_robot_really_sweeps_on_a_course_is_in_it(course: float, way: float) -> None:
    """Each point on the border of its box, `way` farther on, is met by then if it is ahead now."""
    swept = SE2(way * math.cos(course), way * math.sin(course), course) @ border_of(BOX)
    along = swept @ np.array([math.cos(course), math.sin(course)])
    wider = BOX.half_width + 1e-6
    for point in swept[along > BOX.front + 1e-9]:
        met = free_ways(np.array([course]), point[None], np.zeros(1), BOX.front, wider)[0]
        assert met <= way + TOL_M


@settings(max_examples=150)
@given(course=courses_, x=places, y=places, radius=st.floats(0.0, 0.4))
def test_what_is_in_it_touches_the_box_then_and_not_before(
    course: float, x: float, y: float, radius: float
) -> None:
    point = np.array([[x, y]])
    way = free_ways(np.array([course]), point, np.array([radius]), BOX.front, BOX.half_width)[0]
    if not math.isfinite(way) or way == 0.0:
        return
    gaps = [gap_of(pose.inverse() @ point) for pose in box_at(course, way * SHARES)]
    assert gaps[-1] == pytest.approx(radius, abs=TOL_M)
    assert min(gaps[:-1]) > radius - TOL_M


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
