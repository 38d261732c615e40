"""Border along bearings, residuals against walls, normal equations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from floor_masks import ell, first_wall, mask_of, rectangle, small_camera

from floornav_common.calibration import STEP, calibration_of, moved_cameras
from floornav_common.se2 import SE2
from multi_localizer.floor_kernels import (
    NUM_VALUES,
    gate_weights,
    moved_residuals,
    normal_equations,
    residuals,
)
from multi_localizer.floor_rays import BorderScanner, measured, rays_of_pixels

CAMERA = small_camera()


def walls_of(plan):
    return np.column_stack((plan.corners, plan.tangents, plan.normals, plan.offsets, plan.lengths))


def rows_of(values, pose, plan):
    rows = np.empty((len(values) + 1, NUM_VALUES))
    num = residuals(values, 1, pose.as_array(), walls_of(plan), rows)
    return rows[:num]


def border_of(plan, pose, num=300):
    """Return exact border pixels of a pose, sorted by bearing."""
    bearings = np.linspace(-math.pi, math.pi, num, endpoint=False)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    turned = SE2(0.0, 0.0, pose.yaw) @ ways
    r = first_wall(np.array([pose.x, pose.y]), turned, plan)
    return CAMERA.floor_pixels(ways * r[:, None])


def test_one_pixel_of_noise_spreads_as_the_cameras_jacobian_says():
    pixel = np.array([[200.0, 130.0]])
    values = measured(CAMERA, pixel, np.inf)[0]
    step = 1e-4
    moved = [measured(CAMERA, pixel + d, np.inf)[0] for d in step * np.eye(2)]
    phi = [math.atan2(m[1], m[0]) - math.atan2(values[1], values[0]) for m in moved]
    slopes = np.array([phi, [m[2] - values[2] for m in moved]]) / step
    cov = slopes @ slopes.T
    assert values[3:6] == pytest.approx([cov[0, 0], cov[0, 1], cov[1, 1]], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("size", [(256, 220), (640, 480)])
def test_a_scanned_border_lies_on_the_walls_without_bias(size):
    camera, plan, pose = small_camera(*size), ell(), SE2(-0.3, -0.4, 0.8)
    border = BorderScanner(camera, 1.02 * plan.reach).scan(mask_of(camera, plan, pose))
    z = rows_of(border.values, pose, plan)[:, 0]
    inner = np.abs(z) < 1.0  # a corner that hides makes a pixel or two that lie between
    assert len(z) > 0.9 * border.num_paths
    assert inner.mean() > 0.99
    assert abs(np.mean(z[inner])) < 0.05 and np.std(z[inner]) < 0.35


def test_exact_border_has_no_residuals():
    plan, pose = ell(), SE2(0.2, -0.5, -2.0)
    values = rays_of_pixels(CAMERA, border_of(plan, pose)).values
    assert np.abs(rows_of(values, pose, plan)[:, 0]).max() < 1e-6


def test_residuals_are_in_pixels_and_positive_where_the_border_is_nearer():
    plan, pose = rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.0)
    pixels = border_of(plan, pose)
    middle = np.array(CAMERA.center_px)
    outward = (pixels - middle) / np.linalg.norm(pixels - middle, axis=1, keepdims=True)
    z = rows_of(rays_of_pixels(CAMERA, pixels - 0.1 * outward).values, pose, plan)[:, 0]
    assert (z > 0.03).all() and z.max() == pytest.approx(0.1, rel=0.05)


def test_derivatives_agree_with_differences():
    plan, pose = ell(), SE2(-0.3, -0.4, 0.8)
    values = rays_of_pixels(CAMERA, border_of(plan, pose)).values
    rows = rows_of(values, pose, plan)
    for k, step in enumerate(1e-6 * np.eye(3)):
        up, down = (rows_of(values, SE2(*(pose.as_array() + s * step)), plan) for s in (1, -1))
        same = (up[:, 4] == rows[:, 4]) & (down[:, 4] == rows[:, 4])
        slope = (up[:, 0] - down[:, 0]) / 2e-6
        assert slope[same] == pytest.approx(rows[same, 1 + k], rel=1e-3, abs=1e-2)


def test_eliminated_walls_give_what_solving_for_all_gives():
    plan, pose, wall_sd, offset_sd, sd = rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.5), 0.2, 0.7, 0.3
    pixels = border_of(plan, pose, 120)
    noisy = pixels + np.random.default_rng(0).normal(0.0, 0.3, pixels.shape)
    rows = rows_of(rays_of_pixels(CAMERA, noisy).values, pose, plan)
    H, b = normal_equations(
        rows, np.empty((len(rows), 0)), rows[:, 6], sd, offset_sd, wall_sd, 1e9, 4
    )
    meters = 1.0 / np.hypot(rows[:, 1], rows[:, 2])
    lean = -rows[:, 3] * meters * rows[:, 5]
    own = np.zeros((len(rows), 8))
    for wall in range(4):
        is_own = rows[:, 4] == wall
        own[is_own, 2 * wall], own[is_own, 2 * wall + 1] = -1.0, -lean[is_own]
    A = np.column_stack((rows[:, 1:4], -np.ones(len(rows)), own)) / sd
    full = A.T @ A + np.diag([0, 0, 0, offset_sd**-2, *[wall_sd**-2] * 8])
    d = np.linalg.solve(full, -A.T @ rows[:, 0] / sd)
    assert np.linalg.solve(H, b) == pytest.approx(d[:4], rel=1e-6)
    assert np.linalg.inv(H)[:3, :3] == pytest.approx(np.linalg.inv(full)[:3, :3], rel=1e-6)


def test_the_gate_takes_neighbors_of_obstacles_out_too():
    rows = np.zeros((12, NUM_VALUES))
    rows[:, 6] = 1.0
    rows[5, 0] = 9.0
    weights = np.empty(12)
    gate_weights(rows, 0.0, 1.0, 2, weights)
    assert np.flatnonzero(weights == 0.0).tolist() == [3, 4, 5, 6, 7]


def test_floor_to_the_edge_of_the_view_is_no_border():
    scanner = BorderScanner(CAMERA, 3.0)
    assert len(scanner.scan(np.full((220, 256), 255, np.uint8)).values) == 0
    assert len(scanner.scan(np.zeros((220, 256), np.uint8)).values) == 0
    with pytest.raises(ValueError, match=r"\(220, 256\)"):
        scanner.scan(np.zeros((100, 100), np.uint8))


def test_a_far_wall_of_coarse_pixels_may_lie_off_so_much_more():
    """A wall of whose border a pixel covers k times coarse_m has k times the deviation."""
    plan, pose = rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.5)
    rows = rows_of(rays_of_pixels(CAMERA, border_of(plan, pose, 120)).values, pose, plan)
    rows = rows[rows[:, 4] == 2]  # the farthest wall alone
    none = np.empty((len(rows), 0))
    covered = float(np.mean(1.0 / np.hypot(rows[:, 1], rows[:, 2])))
    flat = np.ones(len(rows))
    coarse, _ = normal_equations(rows, none, flat, 0.3, 0.7, 0.1, covered / 3.0, 4)
    wide, _ = normal_equations(rows, none, flat, 0.3, 0.7, 0.3, 1e9, 4)
    narrow, _ = normal_equations(rows, none, flat, 0.3, 0.7, 0.1, 1e9, 4)
    assert coarse == pytest.approx(wide, rel=1e-6)
    assert narrow[0, 0] > 1.5 * coarse[0, 0]


def test_residuals_move_with_the_calibration_as_refitting_them_says():
    one = {"center_u_px": np.array([0.1, 0.0]), "height_m": np.array([0.0, 0.001])}
    plan, pose = rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.5)
    pixels = border_of(plan, pose, 60)
    known = replace(CAMERA, calibration=calibration_of(one, np.eye(2)))
    rays = rays_of_pixels(known, pixels)
    rows, walls = rows_of(rays.values, pose, plan), walls_of(plan)
    moves = np.empty((len(rows), 2))
    moved_residuals(rays.values, rays.moves, pose.as_array(), walls, rows, moves)
    for k, pair in enumerate(moved_cameras(known)):
        up, down = (rows_of(rays_of_pixels(c, pixels).values, pose, plan) for c in pair)
        slope = (up[:, 0] - down[:, 0]) / (2.0 * STEP)
        assert moves[:, k] == pytest.approx(slope, rel=0.02, abs=1e-3)


def test_a_scanner_through_another_camera_sees_what_its_own_would():
    plan, pose = rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.5)
    mask = mask_of(CAMERA, plan, pose)
    off = replace(CAMERA, height_m=1.01 * CAMERA.height_m)
    scanner = BorderScanner(CAMERA, 3.2)
    nearer, own = scanner.scan(mask), scanner.through(off).scan(mask)
    assert own.values[:, 2] == pytest.approx(nearer.values[:, 2] / 1.01, rel=1e-6)
    assert own.num_paths == nearer.num_paths
