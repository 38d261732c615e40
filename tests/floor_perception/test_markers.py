"""Markers: classes by color, blobs, bearings to a part of a pixel."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib import resources
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_floors import GRAY, painted, robot_body, upright_camera

from floor_perception.markers import MarkerClass, MarkerDetector, class_table, load_marker_classes

MAGENTA, YELLOW = (230, 26, 191), (242, 204, 13)
CLASSES = {
    "robots": MarkerClass(color=(0.9, 0.1, 0.75), radius=0.1),
    "goal_yellow": MarkerClass(color=(0.95, 0.8, 0.05)),
}
CAMERA = upright_camera((640, 480))
DETECTOR = MarkerDetector(CAMERA, CLASSES)


def with_disk(
    center: tuple[float, float], radius: float, color: tuple[int, int, int]
) -> np.ndarray:
    """Return a floor's picture with a disk in the image, its edge blended."""
    image = painted(CAMERA, [(robot_body(), GRAY)], 2.0)
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    share = np.clip(radius + 0.5 - np.hypot(u - center[0], v - center[1]), 0.0, 1.0)[..., None]
    return np.rint(share * np.array(color) + (1.0 - share) * image).astype(np.uint8)


def test_nothing_is_seen_where_nothing_is() -> None:
    image = painted(CAMERA, [(robot_body(), GRAY)], 2.0)
    assert DETECTOR.detect(image, "rgb") == {"robots": [], "goal_yellow": []}


@settings(max_examples=20)
@given(st.floats(-math.pi, math.pi), st.floats(100.0, 200.0), st.floats(5.0, 9.0))
def test_bearings_are_known_to_a_third_of_a_pixel(
    bearing: float, radius_px: float, disk_px: float
) -> None:
    center = tuple(
        c + radius_px * f
        for c, f in zip(CAMERA.center_px, (math.cos(bearing), math.sin(bearing)), strict=True)
    )
    (marker,) = DETECTOR.detect(with_disk(center, disk_px, MAGENTA), "rgb")["robots"]
    off = math.remainder(marker.bearing - bearing, 2.0 * math.pi)
    assert abs(off) * radius_px < 0.34
    assert marker.area_px == pytest.approx(math.pi * disk_px**2, rel=0.35)


@pytest.mark.parametrize(
    ("yaw", "roll", "pitch"), [(0.9, 0.0, 0.0), (0.0, 0.2, -0.15), (-2.0, -0.1, 0.2)]
)
def test_bearings_are_those_of_the_floors_frame_however_the_camera_is_mounted(
    yaw: float, roll: float, pitch: float
) -> None:
    """A cone's foot at a known place; along rays turned by hand its pixel is found again."""
    camera = replace(CAMERA, yaw_rad=yaw, roll_rad=roll, pitch_rad=pitch)
    place = np.array([0.4, 0.3])
    center = camera.floor_pixels(place)
    plain = CAMERA.floor_rays(center)
    assert abs(math.remainder(math.atan2(plain[1], plain[0]) - 0.6435, 2.0 * math.pi)) > 0.03
    image = np.zeros((480, 640, 3), dtype=np.uint8)
    cv2.circle(image, (round(center[0]), round(center[1])), 6, MAGENTA, -1)
    (marker,) = MarkerDetector(camera, CLASSES).detect(image, "rgb")["robots"]
    assert marker.bearing == pytest.approx(0.6435, abs=0.01)  # atan(3 / 4)


def test_each_class_has_its_own_blobs_the_largest_first() -> None:
    image = with_disk((500.0, 240.0), 6.0, MAGENTA)
    for center, radius, color in (((320, 400), 9, MAGENTA), ((200, 150), 8, YELLOW)):
        cv2.circle(image, center, radius, color, -1)
    found = DETECTOR.detect(image, "rgb")
    areas = [marker.area_px for marker in found["robots"]]
    assert len(areas) == 2 and areas == sorted(areas, reverse=True)
    assert len(found["goal_yellow"]) == 1
    turned = DETECTOR.detect(np.ascontiguousarray(image[..., ::-1]), "bgr")
    assert turned == found


def test_specks_and_hidden_blobs_do_not_count() -> None:
    image = with_disk((500.0, 240.0), 6.0, MAGENTA)
    image[100, 320] = MAGENTA
    assert len(DETECTOR.detect(image, "rgb")["robots"]) == 1
    hidden = np.full((480, 640), 255, dtype=np.uint8)
    hidden[:, 400:] = 0
    assert MarkerDetector(CAMERA, CLASSES, hidden).detect(image, "rgb")["robots"] == []


def test_images_of_another_size_give_the_same_bearings() -> None:
    image = with_disk((500.0, 300.0), 9.0, MAGENTA)
    (large,) = DETECTOR.detect(image, "rgb")["robots"]
    half = cv2.resize(image, (320, 240), interpolation=cv2.INTER_AREA)
    (small,) = DETECTOR.detect(half, "rgb")["robots"]
    assert small.bearing == pytest.approx(large.bearing, abs=0.005)


@pytest.mark.parametrize("bearing", [0.3, 2.0, -3.0])
def test_the_ends_of_a_wide_marker_are_known_to_half_a_pixel(bearing: float) -> None:
    """A sector 20 degrees wide, from 120 to 200 px, and a speck of its color apart from it."""
    half = math.radians(10.0)
    rays = CAMERA.floor_rays(np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1))
    off = np.abs(np.remainder(np.arctan2(rays[..., 1], rays[..., 0]) - bearing + np.pi, 2 * np.pi))
    u, v = np.meshgrid(np.arange(640.0), np.arange(480.0))
    R = np.hypot(u - CAMERA.center_px[0], v - CAMERA.center_px[1])
    image = np.zeros((480, 640, 3), dtype=np.uint8)
    image[(np.abs(off - np.pi) < half) & (R > 120.0) & (R < 200.0)] = YELLOW
    image[240, 400] = YELLOW
    classes = {"goal_yellow": replace(CLASSES["goal_yellow"], has_ends=True)}
    (marker,) = MarkerDetector(CAMERA, classes).detect(image, "rgb")["goal_yellow"]
    assert marker.ends is not None
    for end, true in zip(marker.ends, (bearing - half, bearing + half), strict=True):
        assert abs(math.remainder(end - true, 2.0 * math.pi)) * 120.0 < 0.6


def test_a_color_of_two_classes_goes_to_the_nearer() -> None:
    classes = {
        "wide": MarkerClass(color=(0.9, 0.1, 0.75), radius=0.6),
        "narrow": MarkerClass(color=(0.95, 0.8, 0.05), radius=0.1),
    }
    table = class_table(classes, "rgb").reshape(64, 64, 64)
    assert table[tuple(v // 4 for v in YELLOW)] == 2
    assert table[tuple(v // 4 for v in MAGENTA)] == 1
    assert table[0, 0, 0] == 0


def test_the_packages_colors_load() -> None:
    path = Path(str(resources.files("floor_perception") / "colors" / "soccer.yaml"))
    assert list(load_marker_classes(path)) == ["robots", "goal_yellow", "goal_blue"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "class names"), ("{", "not YAML"), ("a: 3", "expected a mapping"),
        ("a: {hue: 3}", "hue"), ("a: {color: [1, 0]}", "color must hold"),
        ("a: {radius: -1.0}", "radius must be"),
    ],
)  # fmt: skip
def test_a_file_that_is_none_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        load_marker_classes(path)
