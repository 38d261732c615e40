"""Where a pair's left camera is, by hand, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from multi_localizer.stereo_cameras import CameraModel
from multi_localizer.stereo_mount import mounted_camera

FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def model(focal: float = 280.0, center: tuple[float, float] = (150.0, 118.0)) -> CameraModel:
    projection = np.array(
        [[focal, 0.0, center[0], 0.0], [0.0, focal, center[1], 0.0], [0.0, 0.0, 1.0, 0.0]]
    )
    return CameraModel((320, 240), np.zeros(0), projection[:, :3], np.eye(3), projection)


def at(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_matrix() @ FORWARD
    T[:3, 3] = (0.2, -0.1, 0.9)
    return T


@pytest.mark.parametrize("yaw", [0.0, 1.3, math.pi, -2.0])
def test_a_level_camera_by_hand(yaw):
    camera = mounted_camera(at(yaw), model(), 280.0, 0.1)
    assert (camera.x_m, camera.y_m, camera.height_m) == pytest.approx((0.2, -0.1, 0.9))
    assert math.cos(camera.yaw - yaw) == pytest.approx(1.0)
    assert camera.center_px == (150.0, 118.0) and camera.pixel_meters == pytest.approx(28.0)
    assert (camera.width_px, camera.height_px) == (320, 240)


def test_what_does_not_look_level_is_refused():
    mounted_camera(at(0.4, pitch=0.03), model(), 280.0, 0.1)
    with pytest.raises(ValueError, match="tilted by 10 degrees"):
        mounted_camera(at(0.4, pitch=math.radians(10.0)), model(), 280.0, 0.1)
    with pytest.raises(ValueError, match="tilted by 10 degrees"):
        mounted_camera(at(0.4, roll=math.radians(10.0)), model(), 280.0, 0.1)
    with pytest.raises(ValueError, match="optical"):
        mounted_camera(np.eye(4), model(), 280.0, 0.1)
    with pytest.raises(ValueError, match="upside down"):
        mounted_camera(at(0.4, roll=math.pi), model(), 280.0, 0.1)


def test_disparities_of_another_camera_are_refused():
    with pytest.raises(ValueError, match="focal length is 300 px, camera_info's 280"):
        mounted_camera(at(0.0), model(), 300.0, 0.1)


def test_a_camera_that_is_not_rectified_is_refused():
    bent = replace(model(), distortion=np.array([-0.2, 0.05]))
    with pytest.raises(ValueError, match="left P is K, yet the lens distorts"):
        mounted_camera(at(0.0), bent, 280.0, 0.1)
    squeezed = model().projection.copy()
    squeezed[1, 1] = 260.0
    with pytest.raises(ValueError, match="focal lengths 280 and 260"):
        mounted_camera(at(0.0), replace(model(), projection=squeezed), 280.0, 0.1)


def test_numbers_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="camera_info holds numbers that are not finite"):
        mounted_camera(at(0.0), model(center=(math.nan, 118.0)), 280.0, 0.1)
    with pytest.raises(ValueError, match="must be finite"):
        mounted_camera(at(0.0), model(), math.inf, 0.1)
    with pytest.raises(ValueError, match="must be finite"):
        mounted_camera(at(0.0), model(), 280.0, math.inf)
    lost = at(0.0)
    lost[0, 3] = math.nan
    with pytest.raises(ValueError, match="TF holds numbers that are not finite"):
        mounted_camera(lost, model(), 280.0, 0.1)
