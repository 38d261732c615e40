"""Known points on the floor give the mount back, and the camera with it."""

import numpy as np
import pytest

from floor_perception.points_fit import fit_points
from floornav_common.cameras.equidistant import EquidistantCamera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera

CAMERA = UnifiedCamera(
    width_px=640, height_px=480, xi=0.97, fx_px=240.0, fy_px=240.0, center_u_px=322.0,
    center_v_px=236.0, max_radius_px=238.0,
)  # fmt: skip
TRUTH = FloorCamera(CAMERA, 0.4, 0.02, -0.015, 2.3, (0.05, -0.02))
POINTS = np.random.default_rng(0).uniform(-2.0, 2.0, (30, 2))


def pixels_of(floor: FloorCamera, sd_px: float = 0.0) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0.0, sd_px, POINTS.shape)
    return np.asarray(floor.floor_pixels(POINTS - floor.position_m) + noise)


def mount(floor: FloorCamera) -> list[float]:
    tilt = [floor.roll_rad, floor.pitch_rad, floor.yaw_rad]
    return [floor.height_m, *tilt, *floor.position_m]


def test_exact_points_give_the_mount_back() -> None:
    fit = fit_points(pixels_of(TRUTH), POINTS, CAMERA, ("height", "yaw", "tilt", "position"))
    assert mount(fit.floor_camera) == pytest.approx(mount(TRUTH), abs=1e-6)
    assert fit.floor_camera.camera == CAMERA and fit.rms_px < 1e-6


def test_what_is_not_freed_stays() -> None:
    upright = FloorCamera(CAMERA, 0.4, yaw_rad=-2.0, position_m=(0.1, 0.0))
    fit = fit_points(pixels_of(upright, 0.2), POINTS, CAMERA, position_m=(0.1, 0.0))
    assert fit.statistics.names == ("height_m", "yaw_rad")
    assert mount(fit.floor_camera)[1:3] == [0.0, 0.0]
    assert fit.floor_camera.position_m == (0.1, 0.0)
    low, high = fit.statistics.interval("height_m")
    assert low - 0.002 < 0.4 < high + 0.002 and high - low < 0.01


def test_any_kind_of_camera_does() -> None:
    lens = EquidistantCamera(
        width_px=640, height_px=480, fx_px=150.0, fy_px=150.0, center_u_px=320.0,
        center_v_px=240.0, looks="down",
    )  # fmt: skip
    truth = FloorCamera(lens, 1.2, 0.03, 0.05, 0.5)
    fit = fit_points(pixels_of(truth), POINTS, lens, ("height", "yaw", "tilt"))
    assert mount(fit.floor_camera) == pytest.approx(mount(truth), abs=1e-6)


def test_the_camera_comes_back_with_its_mount() -> None:
    guess = UnifiedCamera(
        width_px=640, height_px=480, xi=1.0, fx_px=160.0, fy_px=160.0, center_u_px=319.5,
        center_v_px=239.5,
    )  # fmt: skip
    every = ("camera", "height", "yaw", "tilt", "position")
    fit = fit_points(pixels_of(TRUTH), POINTS, guess, every)
    assert fit.rms_px < 1e-4
    assert mount(fit.floor_camera) == pytest.approx(mount(TRUTH), abs=1e-3)
    assert fit.floor_camera.center_px == pytest.approx(CAMERA.center_px, abs=0.01)
    # With noise single values trade off, which is said; the floor is right all the same.
    fit = fit_points(pixels_of(TRUTH, 0.2), POINTS, guess, every)
    assert fit.statistics.is_nearly_degenerate
    near = np.hypot(*(POINTS - TRUTH.position_m).T) < 1.5
    seen = fit.floor_camera.floor_points(pixels_of(TRUTH)) + fit.floor_camera.position_m
    assert np.allclose(seen[near], POINTS[near], atol=0.02)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda px, p: (px[:3], p[:3]), "at least 4 points"),
        (lambda px, p: (px[:-1], p), "two lists"),
        (lambda px, p: (px, np.where(p > 1.9, np.nan, p)), "must be finite"),
        (lambda px, p: (px, 1000.0 * p[::-1]), "do not fit"),
        (lambda px, p: (px * 0.0 - 5.0, p), "must see the floor"),
    ],
)
def test_points_that_cannot_be_are_refused(change, said: str) -> None:
    pixels, points = change(pixels_of(TRUTH), POINTS)
    with pytest.raises(ValueError, match=said):
        fit_points(pixels, points, CAMERA)


def test_an_unknown_group_is_refused() -> None:
    with pytest.raises(ValueError, match="'roll'"):
        fit_points(pixels_of(TRUTH), POINTS, CAMERA, ("roll",))
