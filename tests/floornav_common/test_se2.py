"""SE(2): known answers, then the laws of a group."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2, wrap_angle

TOL = 1e-9
coordinate = st.floats(-100.0, 100.0)
poses = st.builds(SE2, coordinate, coordinate, st.floats(-7.0, 7.0))


def assert_same(a: SE2, b: SE2, tol: float = 1e-7) -> None:
    assert a.between(b).distance < tol
    assert abs(wrap_angle(a.yaw - b.yaw)) < tol


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.0, 0.0), (math.pi, math.pi), (-math.pi, math.pi), (3.0 * math.pi, math.pi), (-0.1, -0.1),
     (2.0 * math.pi + 0.25, 0.25)],
)  # fmt: skip
def test_angles_wrap_into_the_half_open_turn(angle, wrapped):
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=TOL)


def test_a_quarter_turn_moves_points_to_the_left():
    T_a_b = SE2(1.0, 2.0, math.pi / 2.0)
    assert T_a_b @ np.array([[1.0, 0.0], [0.0, 1.0]]) == pytest.approx(
        np.array([[1.0, 3.0], [0.0, 2.0]]), abs=TOL
    )


def test_composition_moves_points_like_one_after_the_other():
    T_a_b, T_b_c = SE2(1.0, 2.0, 0.3), SE2(-0.5, 0.2, 2.0)
    points = np.array([[0.1, 0.2], [3.0, -1.0]])
    assert (T_a_b @ T_b_c) @ points == pytest.approx(T_a_b @ (T_b_c @ points), abs=TOL)


def test_interpolation_takes_the_shorter_turn():
    middle = SE2(0.0, 0.0, 3.0).interpolate(SE2(2.0, 0.0, -3.0), 0.5)
    assert middle.x == pytest.approx(1.0, abs=TOL)
    assert abs(middle.yaw) == pytest.approx(math.pi, abs=TOL)


def test_a_pose_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="finite"):
        SE2(0.0, math.nan, 0.0)


@given(poses)
def test_inverse_undoes(pose):
    assert_same(pose @ pose.inverse(), SE2.identity())
    assert_same(pose.inverse() @ pose, SE2.identity())


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    assert_same((a @ b) @ c, a @ (b @ c), 1e-6)


@given(poses, poses)
def test_between_is_what_leads_from_one_to_the_other(a, b):
    assert_same(a @ a.between(b), b)
