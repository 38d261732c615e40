"""Poses with covariances: known answers, laws, and statistics of many errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import (
    PoseEstimate,
    difference,
    fuse,
    mahalanobis,
    moved,
    normalized_error,
    propagate,
)

TOL = 1e-9
poses = st.builds(
    SE2, st.floats(-9, 9), st.floats(-9, 9), st.floats(-3.1, 3.1)
)  # fmt: skip


def spd(seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).normal(0.0, 0.1, (3, 3))
    return root @ root.T + 1e-4 * np.eye(3)


def test_two_equal_ones_meet_halfway_with_half_the_covariance() -> None:
    cov = np.diag([0.04, 0.01, 0.09])
    both = fuse(PoseEstimate(SE2(0, 0, 0), cov), PoseEstimate(SE2(2, 4, 0.2), cov))
    assert both.pose.as_array() == pytest.approx([1.0, 2.0, 0.1], abs=TOL)
    assert both.cov == pytest.approx(cov / 2, abs=TOL)


def test_yaws_on_both_sides_of_pi_meet_at_pi() -> None:
    cov = np.eye(3)
    both = fuse(PoseEstimate(SE2(0, 0, 3.1), cov), PoseEstimate(SE2(0, 0, -3.1), cov))
    assert abs(both.pose.yaw) == pytest.approx(np.pi, abs=TOL)


def test_a_straight_drive_turns_uncertain_yaw_into_uncertain_side() -> None:
    start = PoseEstimate(SE2(0, 0, np.pi / 2), np.diag([1e-6, 1e-6, 0.01]))
    end = propagate(start, SE2(2.0, 0.0, 0.0), 1e-9 * np.eye(3))
    assert end.pose.as_array() == pytest.approx([0.0, 2.0, np.pi / 2], abs=TOL)
    assert end.cov[0, 0] == pytest.approx(1e-6 + 4.0 * 0.01, rel=1e-3)
    assert end.cov[0, 2] == pytest.approx(-2.0 * 0.01, rel=1e-3)


@given(poses, poses, st.integers(0, 99))
def test_fusing_does_not_care_for_the_order(a: SE2, b: SE2, seed: int) -> None:
    if abs(abs(difference(a, b)[2]) - np.pi) < 1e-6:
        return  # opposite yaws have two middles
    first, second = PoseEstimate(a, spd(seed)), PoseEstimate(b, spd(seed + 100))
    ab, ba = fuse(first, second), fuse(second, first)
    assert difference(ab.pose, ba.pose) == pytest.approx(np.zeros(3), abs=1e-6)
    assert ab.cov == pytest.approx(ba.cov, abs=1e-9)
    assert mahalanobis(first, second) == pytest.approx(mahalanobis(second, first), rel=1e-6)


@given(poses, poses, st.integers(0, 99))
def test_there_and_back_is_where_it_was(pose: SE2, way: SE2, seed: int) -> None:
    start = PoseEstimate(pose, spd(seed))
    back = moved(moved(start, way), way.inverse())
    assert difference(back.pose, pose) == pytest.approx(np.zeros(3), abs=1e-7)
    assert back.cov == pytest.approx(start.cov, rel=1e-5, abs=1e-8)


def test_errors_of_many_drives_have_the_propagated_covariance() -> None:
    rng = np.random.default_rng(0)
    start = PoseEstimate(SE2(1.0, -2.0, 0.7), np.diag([0.02, 0.01, 0.02]) ** 2)
    motion, motion_cov = SE2(0.5, 0.1, 0.3), np.diag([0.01, 0.02, 0.01]) ** 2
    end = propagate(start, motion, motion_cov)
    errors = []
    for _ in range(2000):
        dx, dy, dyaw = rng.multivariate_normal(np.zeros(3), start.cov)
        mx, my, myaw = rng.multivariate_normal(np.zeros(3), motion_cov)
        true = SE2(1.0 + dx, -2.0 + dy, 0.7 + dyaw)
        errors.append(
            normalized_error(end.pose, true @ SE2(0.5 + mx, 0.1 + my, 0.3 + myaw), end.cov)
        )
    assert np.mean(errors) == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / 2000))


@pytest.mark.parametrize(
    "cov", [np.eye(2), np.diag([1.0, 1.0, 0.0]), np.full((3, 3), np.nan), np.triu(np.ones((3, 3)))]
)
def test_what_is_no_covariance_is_refused(cov: np.ndarray) -> None:
    with pytest.raises(ValueError, match="cov must be"):
        PoseEstimate(SE2(0, 0, 0), cov)
