"""Method 1: circles through landmarks, and where they meet."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from multi_localizer.landmark_circle import circle_fix, circle_of_pair, meet_again
from multi_localizer.pose_estimate import difference

TOL_M = 1e-6
POLES = np.array([[4.0, 0.0], [-4.0, 0.5], [0.5, 3.0]])
places = st.tuples(st.floats(-3.5, 3.5), st.floats(-2.5, 2.5), st.floats(-3.1, 3.1))


def bearings_from(pose: SE2, points: np.ndarray) -> np.ndarray:
    local = pose.inverse() @ points
    return np.arctan2(local[:, 1], local[:, 0])


def test_the_papers_circle() -> None:
    """3.3: landmarks on the y axis, L apart; the robot sees them under theta, from -x."""
    L, theta = 3.0, 0.7
    circle = circle_of_pair(np.array([0.0, -L / 2]), np.array([0.0, L / 2]), theta)
    assert circle is not None
    assert circle.center == pytest.approx([-L / (2.0 * math.tan(theta)), 0.0], abs=TOL_M)
    assert circle.radius == pytest.approx(L / (2.0 * math.sin(theta)), abs=TOL_M)


@given(places)
def test_the_robot_stands_on_the_circle(place: tuple[float, float, float]) -> None:
    pose = SE2(*place)
    b = bearings_from(pose, POLES[:2])
    circle = circle_of_pair(POLES[0], POLES[1], b[1] - b[0])
    assume(circle is not None and circle.radius < 1e3)
    off = np.hypot(*(np.array([pose.x, pose.y]) - circle.center)) - circle.radius
    assert abs(off) < 1e-6 * max(circle.radius, 1.0)


@given(places)
def test_three_landmarks_give_the_pose(place: tuple[float, float, float]) -> None:
    pose = SE2(*place)
    assume(np.hypot(*(POLES - place[:2]).T).min() > 0.3)
    center = np.array([0.05, -0.45])  # not on the circle through the poles
    radii = np.hypot(*(POLES - center).T)
    assume(abs(np.hypot(place[0] - center[0], place[1] - center[1]) - radii.mean()) > 0.5)
    b = bearings_from(pose, POLES)
    assume(np.abs(np.sin(b - np.roll(b, 1))).min() > 0.02)
    assert difference(circle_fix(POLES, b), pose) == pytest.approx(np.zeros(3), abs=1e-4)


def test_five_landmarks_with_small_errors_give_a_pose_nearby() -> None:
    rng = np.random.default_rng(0)
    points = np.vstack((POLES, [[-3.0, -2.5], [3.0, -2.5]]))
    pose = SE2(0.7, -0.4, 2.0)
    off = [
        difference(circle_fix(points, bearings_from(pose, points) + rng.normal(0, 0.005, 5)), pose)
        for _ in range(200)
    ]
    assert np.abs(np.mean(off, axis=0)).max() < 0.01
    assert np.std(off, axis=0).max() < 0.05


def test_on_the_circle_through_all_three_there_is_no_pose() -> None:
    a = np.array([0.2, 1.5, 3.0, 4.5])
    ring = 2.0 * np.stack((np.cos(a), np.sin(a)), axis=-1)
    assert circle_fix(ring[:3], bearings_from(SE2(*ring[3], 0.3), ring[:3])) is None


def test_two_landmarks_leave_the_circle_open() -> None:
    assert circle_fix(POLES[:2], np.array([0.1, 2.0])) is None


def test_landmarks_in_one_direction_make_no_circle() -> None:
    assert circle_of_pair(POLES[0], POLES[1], 0.0) is None
    assert circle_of_pair(POLES[0], POLES[1], math.pi) is None
    assert circle_of_pair(POLES[0], POLES[0], 0.5) is None


def test_equal_circles_do_not_meet_in_a_place() -> None:
    circle = circle_of_pair(POLES[0], POLES[1], 1.0)
    assert circle is not None and meet_again(circle, circle, POLES[0]) is None


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_bearings_that_are_no_numbers_give_no_pose(bad: float) -> None:
    assert circle_fix(POLES, np.array([0.1, bad, bad])) is None
