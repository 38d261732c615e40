"""What a calibration leaves open: files, sizes, and cameras beside the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.calibration import STEP, Calibration, calibration_of, moved_cameras
from floornav_common.camera_files import load_floor_camera, save_floor_camera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera

CAMERA = FloorCamera(
    UnifiedCamera(
        width_px=256, height_px=220, xi=0.9, fx_px=100.0, fy_px=100.0, center_u_px=127.5,
        center_v_px=109.5,
    ),
    0.2,
)  # fmt: skip
SD = {"center_u_px": 0.1, "height_m": 0.002, "fx_px": 0.5}


def known(correlation: float = 0.0) -> FloorCamera:
    sizes = np.array(list(SD.values()))
    R = np.eye(3)
    R[0, 1] = R[1, 0] = correlation
    one = dict(zip(SD, np.eye(3), strict=True))
    calibration = calibration_of(one, R * np.outer(sizes, sizes))
    return replace(CAMERA, calibration=calibration)


def test_moved_cameras_spread_as_the_covariance_says():
    camera, pixel = known(0.7), np.array([180.0, 100.0])
    pairs = moved_cameras(camera)
    moves = [(a.floor_points(pixel) - b.floor_points(pixel)) / (2.0 * STEP) for a, b in pairs]
    slopes = []
    for name, sd in SD.items():
        step = 1e-4 * sd
        where = "mount" if name == "height_m" else "camera"
        up, down = (
            replace(CAMERA, height_m=0.2 + s * step) if where == "mount"
            else replace(CAMERA, camera=replace(CAMERA.camera, **{
                name: getattr(CAMERA.camera, name) + s * step}))
            for s in (1.0, -1.0)
        )  # fmt: skip
        slopes.append((up.floor_points(pixel) - down.floor_points(pixel)) / (2.0 * step))
    J, S = np.array(slopes).T, np.array(camera.calibration.cov)
    M = np.array(moves).T
    found = M @ M.T
    assert found == pytest.approx(J @ S @ J.T, rel=1e-4)


def test_parameters_that_only_move_together_have_one_axis():
    camera = replace(CAMERA, calibration=calibration_of(
        {"fx_px": np.array([1.0]), "fy_px": np.array([1.0])}, np.array([[0.25]])))  # fmt: skip
    ((up, down),) = moved_cameras(camera)
    for key in ("fx_px", "fy_px"):
        off = getattr(up.camera, key) - getattr(down.camera, key)
        assert abs(off) == pytest.approx(2.0 * STEP * 0.5)


def test_at_twice_the_size_pixels_are_half_as_well_known_and_the_height_the_same():
    found = known().resized(512, 440).calibration
    sds = dict(zip(found.names, np.sqrt(np.diag(np.array(found.cov))), strict=True))
    assert sds["center_u_px"] == pytest.approx(0.2, rel=1e-6)
    assert sds["fx_px"] == pytest.approx(1.0, rel=1e-6)
    assert sds["height_m"] == pytest.approx(0.002, rel=1e-6)


def test_a_file_keeps_the_calibration_and_may_do_without(tmp_path):
    camera = known(0.3)
    save_floor_camera(camera, tmp_path / "camera.yaml")
    assert load_floor_camera(tmp_path / "camera.yaml") == camera
    save_floor_camera(CAMERA, tmp_path / "plain.yaml")
    assert load_floor_camera(tmp_path / "plain.yaml").calibration is None


@pytest.mark.parametrize(
    ("names", "cov", "word"),
    [
        ("[fx_px]", "[[1.0, 0.0]]", "1 x 1"),
        ("[fx_px, xi]", "[[1.0, 2.0], [2.0, 1.0]]", "correlation"),
        ("[fx_px, xi]", "[[1.0, 0.5], [0.4, 1.0]]", "symmetric"),
        ("[focus]", "[[1.0]]", "focus"),
        ("[width_px]", "[[1.0]]", "width_px"),
        ("[fx_px]", "[[.nan]]", "finite"),
        ("[fx_px]", "[[-1.0]]", ">= 0"),
        ("[]", "[]", "at least one"),
    ],
)
def test_what_is_no_calibration_is_refused_with_the_files_name(tmp_path, names, cov, word):
    path = tmp_path / "camera.yaml"
    save_floor_camera(CAMERA, path)
    path.write_text(path.read_text() + f"calibration:\n  names: {names}\n  cov: {cov}\n")
    with pytest.raises(ValueError, match=word) as refused:
        load_floor_camera(path)
    assert str(path) in str(refused.value)


def test_a_calibration_without_a_covariance_is_refused():
    with pytest.raises(ValueError, match="3 x 3"):
        Calibration(tuple(SD), ())
