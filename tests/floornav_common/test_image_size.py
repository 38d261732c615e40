"""Which images are taken for the camera's picture resized."""

from __future__ import annotations

import numpy as np
import pytest
from painted_floors import upright_camera

from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.markers import MarkerClass, MarkerDetector
from floornav_common.image_size import camera_at_size, shape_doubt

CAMERA = upright_camera()
WRONG = [(20, 4000), (4000, 20), (640, 480), (256, 220), (220, 2000), (720, 1280), (220, 296)]


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


@pytest.mark.parametrize("size", [(220, 256), (110, 128), (440, 512), (73, 85), (330, 384)])
def test_the_same_shape_is_beyond_doubt(size: tuple[int, int]) -> None:
    assert shape_doubt(CAMERA, *size) == ""


@pytest.mark.parametrize(
    ("size", "border"),
    [((480, 640), "41 pixels left and right"), ((240, 256), "10 pixels above and below")],
)
def test_another_shape_is_doubtful_by_its_border(size: tuple[int, int], border: str) -> None:
    """By hand: 480 / 220 * 256 = 559 of 640 pixels, 40.7 at each side."""
    doubt = shape_doubt(CAMERA, *size)
    assert f"images are {size[1]} x {size[0]}, camera_model is for 256 x 220" in doubt
    assert border in doubt


def test_detectors_doubt_while_the_images_have_another_shape() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    markers = MarkerDetector(CAMERA, {"red": MarkerClass()})
    for size, is_doubtful in (((220, 256), False), ((480, 640), True), ((440, 512), False)):
        image = np.full((*size, 3), (30, 140, 40), dtype=np.uint8)
        detector.detect(image, "rgb", 0)
        markers.detect(image, "rgb")
        assert [bool(d.size_doubt) for d in (detector, markers)] == [is_doubtful] * 2


def test_images_without_pixels_or_of_another_shape_are_refused_and_the_next_is_seen() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    markers = MarkerDetector(CAMERA, {"red": MarkerClass()})
    for shape in ((0, 0, 3), (1, 1, 3), (20, 4000, 3)):
        image = np.full(shape, 100, dtype=np.uint8)
        with pytest.raises(ValueError, match="image must"):
            detector.detect(image, "rgb", 0)
        with pytest.raises(ValueError, match="image must"):
            markers.detect(image, "rgb")
    green = np.full((220, 256, 3), (30, 140, 40), dtype=np.uint8)
    assert np.isposinf(detector.detect(green, "rgb", 1).scan.ranges).all()


def test_a_mask_that_hides_all_floor_is_refused() -> None:
    hidden = np.zeros((220, 256), dtype=np.uint8)
    with pytest.raises(ValueError, match="must show floor beyond the robot"):
        FloorDetector(CAMERA, FloorDetectorConfig(), hidden)


def test_images_with_hardly_a_pixel_of_floor_say_so() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    assert detector.detect(np.full((7, 8, 3), 100, dtype=np.uint8), "rgb", 0) is None
    assert "at least 50 pixels, got 6" in detector.tracker.reason
