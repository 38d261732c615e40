"""The floor paper's section 4 as published."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_masks import mask_of, rectangle, small_camera
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from multi_localizer.floor_border import convex_hull, row_extremes
from multi_localizer.floor_fit import (
    fit_lines,
    fit_published,
    nearest_edges,
    points_turned,
    project_border,
)
from multi_localizer.floor_moments import polygon_moments
from multi_localizer.pose_estimate import difference

TOL_M, TOL_RAD = 0.03, math.radians(1.5)  # of the published fit in a mask of 256 x 220


def test_row_extremes_are_the_first_and_last_pixels():
    mask = np.zeros((4, 6), np.uint8)
    mask[1, 2:5] = 255
    mask[2, 1] = 255
    assert row_extremes(mask).tolist() == [[2, 1], [1, 2], [4, 1], [1, 2]]


def test_hull_leaves_dents_out():
    square = np.array([[0, 0], [4, 0], [4, 4], [2, 2], [0, 4]], dtype=float)
    assert {tuple(p) for p in convex_hull(square).tolist()} == {(0, 0), (4, 0), (4, 4), (0, 4)}


def test_moments_of_a_turned_rectangle():
    corners = SE2(0.3, -0.2, 0.4) @ rectangle(2.0, 1.0).corners
    for points in (corners, corners[::-1]):
        found = polygon_moments(points)
        assert found.area == pytest.approx(2.0)
        assert found.center == pytest.approx([0.3, -0.2])
        assert found.axis_rad == pytest.approx(0.4)


def test_a_line_is_no_region():
    with pytest.raises(ValueError, match="area"):
        polygon_moments(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]))


def test_eq_16_and_17_by_hand():
    turned = points_turned(np.array([[2.0, 1.0]]), np.array([1.0, 1.0]), math.pi / 2.0)
    assert turned == pytest.approx(np.array([[0.0, -1.0]]))


def test_weights_are_one_over_the_slope_squared():
    camera = small_camera()
    u, v = camera.center_px
    points, weights = project_border(np.array([[u + 60.0, v], [u, v + 100.0]]), camera)
    assert points == pytest.approx(np.array([[0.302, 0.0], [0.0, 1.62]]), abs=0.01)
    assert weights == pytest.approx(camera.camera.floor_slope(np.array([60.0, 100.0])) ** -2.0)


def test_a_corner_beside_two_edges_goes_to_the_nearer():
    plan = rectangle(2.0, 1.0)
    assert nearest_edges(np.array([[0.99, 0.3], [0.5, 0.52]]), plan).tolist() == [0, 1]


@given(
    st.floats(-0.6, 0.6), st.floats(-0.3, 0.3), st.floats(-math.pi, math.pi), st.floats(-0.1, 0.1)
)
@settings(max_examples=40)
def test_exact_points_give_the_exact_pose_from_a_start_nearby(x, y, yaw, turn):
    """As printed eq. 20 and 21 would hold for psi near 0 only."""
    plan, truth = rectangle(2.74, 1.525), SE2(x, y, yaw)
    along = np.linspace(0.05, 0.95, 12)[:, None]
    ends = np.roll(plan.corners, -1, axis=0)
    border = np.concatenate([a + along * (b - a) for a, b in zip(plan.corners, ends, strict=True)])
    seen = truth.inverse() @ border
    center = (truth.inverse() @ np.array([[0.03, -0.02]]))[0]
    found = fit_lines(seen, np.ones(len(seen)), plan, center, turn - yaw, 30)
    assert np.abs(difference(found, truth)).max() < 1e-6


@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.0, -2.6])
def test_both_candidates_come_from_a_mask(yaw):
    camera, plan, truth = small_camera(), rectangle(2.74, 1.525), SE2(0.4, -0.2, yaw)
    found = fit_published(mask_of(camera, plan, truth), camera, plan)
    mates = plan.symmetries[1] @ truth
    for want in (truth, mates):
        errors = [np.abs(difference(pose, want)) for pose in found]
        best = min(errors, key=lambda e: e[2])
        assert max(best[:2]) < TOL_M and best[2] < TOL_RAD


def test_a_mask_without_floor_is_refused():
    camera = small_camera()
    with pytest.raises(ValueError, match="points of the border"):
        fit_published(np.zeros((220, 256), np.uint8), camera, rectangle(2.0, 1.0))
