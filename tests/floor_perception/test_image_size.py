"""Which images are taken for the camera's picture resized."""

from __future__ import annotations

import numpy as np
import pytest
from painted_floors import upright_camera

from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.image_size import camera_at_size
from floor_perception.markers import MarkerClass, MarkerDetector

CAMERA = upright_camera()
WRONG = [(20, 4000), (4000, 20), (640, 480), (256, 220), (220, 2000), (720, 1280)]


def test_the_cameras_own_size_is_left_alone() -> None:
    assert camera_at_size(CAMERA, 220, 256) is CAMERA


@pytest.mark.parametrize("size", [(480, 640), (960, 1280), (110, 128), (440, 512)])
def test_the_same_shape_or_a_border_is_resized(size: tuple[int, int]) -> None:
    camera = camera_at_size(CAMERA, *size)
    assert (camera.height_px, camera.width_px) == size


@pytest.mark.parametrize("size", WRONG)
def test_another_shape_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="as wide for its height"):
        camera_at_size(CAMERA, *size)


def test_images_without_pixels_or_without_floor_are_refused_and_the_next_is_seen() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    markers = MarkerDetector(CAMERA, {"red": MarkerClass()})
    with pytest.raises(ValueError, match="must show floor"):
        detector.detect(np.full((1, 1, 3), 100, dtype=np.uint8), "rgb", 0)
    for shape in ((0, 0, 3), (20, 4000, 3)):
        image = np.full(shape, 100, dtype=np.uint8)
        with pytest.raises(ValueError, match="image must"):
            detector.detect(image, "rgb", 0)
        with pytest.raises(ValueError, match="image must"):
            markers.detect(image, "rgb")
    green = np.full((220, 256, 3), (30, 140, 40), dtype=np.uint8)
    assert np.isposinf(detector.detect(green, "rgb", 1).scan.ranges).all()
