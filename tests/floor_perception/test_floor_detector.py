"""The whole way on painted floors: marks bridged, obstacles kept, light followed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from painted_floors import (
    BROWN,
    GRAY,
    GREEN,
    WHITE,
    Region,
    behind,
    painted,
    robot_body,
    upright_camera,
)

from floor_perception.color_model import chromaticity
from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector, px_per_m
from floor_perception.floor_mask import closing_px
from floor_perception.overlay import overlay

SIZES = [(256, 220), (640, 480)]
WALL = (behind(0.0, math.pi, 1.4), GRAY)
BODY = (robot_body(), GRAY)
S_NS = 1_000_000_000
TOL_M = 0.08


def detector_for(size: tuple[int, int]) -> FloorDetector:
    return FloorDetector(upright_camera(size), FloorDetectorConfig())


def cube_at(x: float, y: float, half: float = 0.065) -> Region:
    """Return what a cube hides: all behind its footprint, seen from the camera's foot."""
    bearing, distance = math.atan2(y, x), math.hypot(x, y)
    return behind(bearing, math.atan2(half, distance), distance - half)


@pytest.mark.parametrize("size", SIZES)
def test_walls_are_where_they_are(size: tuple[int, int]) -> None:
    camera = upright_camera(size)
    scan = detector_for(size).detect(painted(camera, [WALL, BODY], 2.0), "rgb", 0).scan
    assert len(scan.ranges) == 180
    assert (np.abs(scan.ranges - 1.4) < TOL_M).all()
    assert scan.angles[0] == -math.pi and scan.angles[90] == pytest.approx(0.0)


@pytest.mark.parametrize("size", SIZES)
def test_lines_and_stains_are_bridged(size: tuple[int, int]) -> None:
    camera = upright_camera(size)
    marks: list[tuple[Region, tuple[int, int, int]]] = [
        (lambda x, y: np.abs(x - 0.3) < 0.005, WHITE),
        (lambda x, y: np.abs(y) < 0.005, WHITE),
        (lambda x, y: np.abs(np.hypot(x + 0.4, y) - 0.25) < 0.005, WHITE),
        (lambda x, y: np.hypot(x, y + 0.5) < 0.01, BROWN),
    ]
    image = painted(camera, [*marks, WALL, BODY], 2.0)
    scan = detector_for(size).detect(image, "rgb", 0).scan
    assert (np.abs(scan.ranges - 1.4) < TOL_M).all()


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("color", [WHITE, BROWN, (50, 50, 60)])
@pytest.mark.parametrize("place", [(0.3, 0.0), (0.0, 0.95), (-0.5, -0.4)])
def test_cubes_are_never_bridged(
    size: tuple[int, int], color: tuple[int, int, int], place: tuple[float, float]
) -> None:
    camera = upright_camera(size)
    image = painted(camera, [WALL, (cube_at(*place), color), BODY], 2.0)
    scan = detector_for(size).detect(image, "rgb", 0).scan
    off = np.abs(np.angle(np.exp(1j * (scan.angles - math.atan2(place[1], place[0])))))
    distance = math.hypot(*place)
    middle = scan.ranges[off < 0.5 * math.atan2(0.065, distance)]
    assert len(middle) and (np.abs(middle - (distance - 0.065)) < TOL_M).all()


def test_a_shadow_is_floor() -> None:
    camera = upright_camera()
    dark = tuple(int(0.6 * v) for v in GREEN)
    shadow = (behind(0.5, 0.4, 0.3), dark)
    scan = (
        detector_for((256, 220)).detect(painted(camera, [shadow, WALL, BODY], 2.0), "rgb", 0).scan
    )
    assert (np.abs(scan.ranges - 1.4) < TOL_M).all()


def test_a_line_under_the_robot_does_not_end_in_it() -> None:
    camera = upright_camera()
    line: Region = lambda x, y: np.abs(y - 0.16) < 0.01  # noqa: E731, along the robot's side
    scan = detector_for((256, 220)).detect(
        painted(camera, [(line, WHITE), WALL, BODY], 2.0), "rgb", 0
    ).scan  # fmt: skip
    assert not np.isneginf(scan.ranges).any()


def test_channels_in_the_other_order_give_the_same() -> None:
    camera = upright_camera()
    image = painted(camera, [WALL, BODY], 2.0)
    rgb = detector_for((256, 220)).detect(image, "rgb", 0)
    bgr = detector_for((256, 220)).detect(np.ascontiguousarray(image[..., ::-1]), "bgr", 0)
    assert (rgb.mask == bgr.mask).all()


def test_images_of_another_size_are_taken_as_the_resized_cameras() -> None:
    detector = detector_for((256, 220))
    detector.detect(painted(upright_camera(), [WALL, BODY]), "rgb", 0)
    big = painted(upright_camera((640, 480)), [WALL, BODY])
    result = detector.detect(big, "rgb", S_NS)
    assert result.mask.shape == (480, 640)
    assert (np.abs(result.scan.ranges - 1.4) < TOL_M).all()


def test_the_color_follows_a_light_that_changes_slowly() -> None:
    camera, detector = upright_camera(), detector_for((256, 220))
    warm = tuple(int(v * f) for v, f in zip(GREEN, (1.5, 1.0, 0.6), strict=True))
    for k in range(101):
        floor = tuple(a + (b - a) * k / 100 for a, b in zip(GREEN, warm, strict=True))
        image = painted(camera, [WALL, BODY], 2.0, floor=floor)
        result = detector.detect(image, "rgb", k * 300_000_000)
        assert detector.tracker.support > 0.9
    assert detector.color.chroma == pytest.approx(chromaticity(np.array(warm)), abs=0.04)
    assert (np.abs(result.scan.ranges - 1.4) < TOL_M).all()


def test_the_color_never_follows_an_obstacle_that_the_robot_touches() -> None:
    """A wall all along one side, for five minutes."""
    camera, detector = upright_camera(), detector_for((256, 220))
    detector.detect(painted(camera, [WALL, BODY], 2.0), "rgb", 0)
    learned = detector.color
    touching = painted(camera, [(behind(0.0, 1.5, 0.1), BROWN), BODY], 2.0)
    for k in range(1, 301):
        result = detector.detect(touching, "rgb", k * S_NS)
    ahead = np.abs(result.scan.angles) < 1.3
    assert np.isneginf(result.scan.ranges[ahead]).all()
    assert detector.color.chroma == pytest.approx(learned.chroma, abs=0.005)


def test_an_obstacle_around_most_of_the_robot_stops_the_following_and_is_said() -> None:
    camera, detector = upright_camera(), detector_for((256, 220))
    detector.detect(painted(camera, [WALL, BODY], 2.0), "rgb", 0)
    corner = painted(camera, [(behind(0.0, 2.3, 0.1), BROWN), BODY], 2.0)
    for k in range(1, 61):
        result = detector.detect(corner, "rgb", k * S_NS)
    assert "of the ring" in detector.tracker.reason
    assert np.isneginf(result.scan.ranges[np.abs(result.scan.angles) < 2.1]).all()


def test_another_lamp_is_learned_after_a_while() -> None:
    camera, detector = upright_camera(), detector_for((256, 220))
    detector.detect(painted(camera, [WALL, BODY], 2.0), "rgb", 0)
    other = painted(camera, [WALL, BODY], 2.0, floor=(90, 80, 30))
    first = detector.detect(other, "rgb", S_NS)
    assert np.isneginf(first.scan.ranges).all()
    for k in range(2, 15):
        last = detector.detect(other, "rgb", S_NS + k * 100_000_000)
    assert (np.abs(last.scan.ranges - 1.4) < TOL_M).all()


def test_without_a_color_that_prevails_there_is_no_result() -> None:
    camera, detector = upright_camera(), detector_for((256, 220))
    thirds = [
        (behind(2.0 * math.pi / 3.0 * k, math.pi / 3.0, 0.0), color)
        for k, color in enumerate((BROWN, GRAY))
    ]
    assert detector.detect(painted(camera, thirds), "rgb", 0) is None
    assert "not known" in detector.tracker.reason


def test_settings_that_the_camera_does_not_fit_leave_the_old_ones() -> None:
    detector = detector_for((256, 220))
    config = FloorDetectorConfig()
    with pytest.raises(ValueError, match="must see the floor"):
        detector.reconfigure(replace(config, template=replace(config.template, horizon_m=90.0)))
    image = painted(upright_camera(), [WALL, BODY])
    assert detector.detect(image, "rgb", 0).scan.range_max == 2.5


def test_the_closing_is_as_wide_as_a_mark_where_the_floor_is_largest() -> None:
    assert closing_px(0.0, 500.0) == 1
    assert closing_px(0.02, 200.0) == 5
    assert closing_px(0.02, 450.0) == 11
    camera = upright_camera()
    near, far = px_per_m(camera, 0.2), px_per_m(camera, 1.0)
    assert near > 1.5 * far
    ends = camera.floor_pixels(np.array([[0.2, -0.005], [0.2, 0.005]]))
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(0.01 * near, rel=0.05)


def test_the_overlay_draws_on_a_copy() -> None:
    camera, detector = upright_camera(), detector_for((256, 220))
    image = painted(camera, [WALL, BODY])
    result = detector.detect(image, "bgr", 0)
    before = image.copy()
    drawn = overlay(image, result.mask, result.scan, camera)
    assert (image == before).all() and drawn.shape == image.shape
    assert (drawn[result.mask > 0] != image[result.mask > 0]).any()


def test_an_image_without_color_is_refused() -> None:
    with pytest.raises(ValueError, match="image must be"):
        detector_for((256, 220)).detect(np.zeros((220, 256), dtype=np.uint8), "rgb", 0)
