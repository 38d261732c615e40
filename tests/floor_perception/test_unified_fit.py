"""Boards seen by a known camera give it back, in any order of corners and seen in a mirror."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from floor_perception.board_pose import board_pose, posed, posed_jacobian
from floor_perception.board_view import INTRINSICS, BoardView, view_jacobian, view_pixels
from floor_perception.checkerboard import board_points
from floor_perception.unified_fit import fit_unified
from floornav_common.cameras.unified import UnifiedCamera

SIZE = (1280, 1024)
BOARD = board_points((6, 8))
ROUND = np.array([1.0, 330.0, 330.0, 645.0, 520.0, 0.0, 0.0, 0.0, 0.0, 0.0])
FULL = np.array([0.9, 320.0, 321.0, 643.0, 519.0, 0.0, -0.05, 0.01, 0.002, -0.001])


def poses(count: int, seed: int = 0) -> np.ndarray:
    """Return poses of boards around the camera, 8 to 12 squares away, facing it."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        bearing = 2.0 * np.pi * k / count
        theta = rng.uniform(0.5, 1.3)
        way = np.array(
            (np.sin(theta) * np.cos(bearing), np.sin(theta) * np.sin(bearing), np.cos(theta))
        )
        turn = Rotation.align_vectors([way], [[0.0, 0.0, 1.0]])[0]
        turn = turn * Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3))
        middle = turn.apply([2.5, 3.5, 0.0])
        found.append(np.concatenate((turn.as_rotvec(), rng.uniform(8, 12) * way - middle)))
    return np.array(found)


def views(intrinsics: np.ndarray, count: int, sd_px: float = 0.0, seed: int = 0) -> list[BoardView]:
    rng = np.random.default_rng(seed)
    return [
        BoardView(BOARD, view_pixels(intrinsics, pose, BOARD) + rng.normal(0, sd_px, BOARD.shape))
        for pose in poses(count, seed)
    ]


def values(camera: UnifiedCamera) -> np.ndarray:
    return np.array([getattr(camera, name) for name in INTRINSICS])


def test_exact_corners_give_the_camera_back() -> None:
    fit = fit_unified(views(ROUND, 6), SIZE, model="round")
    assert np.allclose(values(fit.camera), ROUND, atol=1e-3)
    assert fit.rms_px < 1e-5
    fit = fit_unified(views(FULL, 8), SIZE, model="full")
    assert fit.rms_px < 1e-4
    assert np.allclose(values(fit.camera)[1:5], FULL[1:5], rtol=1e-2)


def test_the_model_is_as_rich_as_the_data_ask() -> None:
    assert fit_unified(views(ROUND, 6, 0.2, 1), SIZE).model == "round"
    assert fit_unified(views(FULL, 8, 0.05, 1), SIZE).model == "full"


def test_intervals_hold_the_truth_and_residuals_the_noise() -> None:
    held = []
    for seed in range(6):
        fit = fit_unified(views(ROUND, 6, 0.3, seed), SIZE, model="round")
        truth = ROUND[[0, 1, 3, 4]]
        held.append(np.abs(fit.statistics.values - truth) < 1.5 * fit.statistics.half_widths)
        assert fit.statistics.residual_sd == pytest.approx(0.3, rel=0.15)
    assert np.mean(held) > 0.9


def test_neither_corner_order_nor_a_mirror_matters() -> None:
    plain = views(ROUND, 6, 0.2)
    turned = [replace(view, pixels=view.pixels[::-1]) for view in plain]
    flipped = [
        replace(view, pixels=view.pixels.reshape(8, 6, 2)[:, ::-1].reshape(-1, 2)) for view in plain
    ]
    mirrored = [
        replace(view, pixels=np.array([2 * 645.0, 0.0]) + view.pixels * (-1.0, 1.0))
        for view in plain
    ]
    expected = fit_unified(plain, SIZE, model="round")
    for others in (turned, flipped, mirrored):
        fit = fit_unified(others, SIZE, model="round")
        assert fit.rms_px == pytest.approx(expected.rms_px, rel=1e-4)
        assert fit.camera.xi == pytest.approx(expected.camera.xi, abs=1e-3)
        assert fit.camera.fx_px == pytest.approx(expected.camera.fx_px, rel=1e-3)


def test_the_camera_sees_boards_where_the_fit_does() -> None:
    """The fit's own formulas are the camera's: posed corners project to the fitted pixels."""
    fit = fit_unified(views(FULL, 8, 0.2), SIZE, model="full", looks="up")
    for view, pose, off in zip(views(FULL, 8, 0.2), fit.poses, fit.residuals_px, strict=True):
        assert np.allclose(fit.camera.project(posed(pose, BOARD)), view.pixels - off, atol=1e-6)


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000))
def test_derivatives_are_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    intrinsics = FULL * rng.uniform(0.9, 1.1, len(FULL))
    intrinsics[5] = rng.uniform(-2.0, 2.0)
    pose = poses(5, seed)[rng.integers(5)]
    by_own, by_pose = view_jacobian(intrinsics, pose, BOARD)
    for J, vector, function in (
        (by_own, intrinsics, lambda p: view_pixels(p, pose, BOARD)),
        (by_pose, pose, lambda p: view_pixels(intrinsics, p, BOARD)),
    ):
        for k in range(len(vector)):
            step = np.zeros(len(vector))
            step[k] = 1e-6 * max(1.0, abs(vector[k]))
            expected = (function(vector + step) - function(vector - step)) / (2 * step[k])
            assert np.allclose(J[..., k], expected, atol=1e-5 * max(1.0, np.abs(expected).max()))


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000))
def test_a_board_is_placed_from_its_rays(seed: int) -> None:
    pose = poses(5, seed)[seed % 5]
    points = posed(pose, BOARD)
    found = board_pose(BOARD, points / np.linalg.norm(points, axis=1, keepdims=True))
    assert np.allclose(posed(found, BOARD), points, atol=1e-6)


def test_a_turn_by_nothing_has_its_derivative() -> None:
    J = posed_jacobian(np.zeros(6), BOARD)
    # d(w x p): about x moves y of the board up in z.
    assert np.allclose(J[:, 2, 0], BOARD[:, 1]) and np.allclose(J[:, :, 3:], np.eye(3))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda v: v[:2], "at least 3 views"),
        (lambda v: [v[0]] * 4, "do not determine|condition"),
        (lambda v: [replace(v[0], pixels=v[0].pixels * np.nan), *v[1:]], "view 1: .*finite"),
        (lambda v: [replace(v[0], pixels=v[0].pixels[:5]), *v[1:]], "view 1: points and pixels"),
    ],
)
def test_views_that_tell_no_camera_are_refused(change, said: str) -> None:
    broken = change(views(ROUND, 5, 0.1))
    if "condition" in said:  # one pose again and again: refused, or said to be nearly degenerate
        assert fit_unified(broken, SIZE, model="round").statistics.is_nearly_degenerate
        return
    with pytest.raises(ValueError, match=said):
        fit_unified(broken, SIZE)
