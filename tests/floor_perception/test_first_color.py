"""The floor's color learned from nothing: by what lies inside, not by what fills the most."""

from __future__ import annotations

import math

import numpy as np
import pytest
from painted_floors import BROWN, GRAY, GREEN, WHITE, Region, behind, painted, robot_body
from painted_floors import upright_camera as camera_of

from floor_perception.color_model import chromaticity
from floor_perception.config import ColorConfig, FloorDetectorConfig
from floor_perception.first_color import learn_first, order_outward
from floor_perception.floor_detector import FloorDetector

BODY = (robot_body(0.16), GRAY)
TOUCH_M = 0.095


def corner(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray((x > TOUCH_M) | (y > TOUCH_M))


def learned(*regions: tuple[Region, tuple[int, int, int]]) -> FloorDetector:
    """Return a detector that has seen one picture."""
    detector = FloorDetector(camera_of(), FloorDetectorConfig())
    detector.detect(painted(camera_of(), [*regions, BODY], 2.0), "rgb", 0)
    return detector


def assert_green(detector: FloorDetector) -> None:
    assert detector.color is not None, detector.tracker.reason
    assert detector.color.chroma == pytest.approx(chromaticity(np.array(GREEN)), abs=0.02)


def test_a_robot_that_touches_both_walls_of_a_corner_learns_the_floor() -> None:
    """Seen from the corner the walls fill more than half of the ring."""
    detector = learned((corner, WHITE))
    assert detector.tracker.support < 0.5
    assert_green(detector)
    ranges = detector.detect(
        painted(camera_of(), [(corner, WHITE), BODY], 2.0), "rgb", 1
    ).scan.ranges  # fmt: skip
    assert np.isneginf(ranges[90]) and np.isneginf(ranges[135])  # ahead and to the left
    assert np.isposinf(ranges[22])  # behind to the right


@pytest.mark.parametrize("bearing", [0.0, 1.0, -2.5])
def test_a_wall_that_the_robot_touches_is_not_learned(bearing: float) -> None:
    def wall(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(x * math.cos(bearing) + y * math.sin(bearing) > TOUCH_M)

    assert_green(learned((wall, WHITE)))


def test_cubes_on_both_sides_do_not_outvote_the_floor_between_them() -> None:
    cubes = [(behind(k * math.pi, 0.6, 0.1), BROWN) for k in range(2)]
    assert_green(learned(*cubes))


def test_lines_under_the_robot_prove_nothing() -> None:
    lines: list[Region] = [
        lambda x, y: np.abs(x - 0.17) < 0.006,
        lambda x, y: np.abs(y) < 0.006,
    ]
    assert_green(learned(*((line, WHITE) for line in lines)))


def test_walls_all_around_but_for_a_gap_are_refused() -> None:
    """A dead end: too little floor to be sure of, and what prevails begins behind it."""

    def dead_end(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray((x > 0.12) | (np.abs(y) > 0.12))

    detector = learned((dead_end, WHITE))
    assert detector.color is None
    assert "begins behind another" in detector.tracker.reason


def test_the_order_outward_is_counted_by_direction() -> None:
    """Two directions of ten pixels each: 0 then 1; one pixel of 1, then 0."""
    distances = np.tile(np.linspace(0.0, 1.0, 10), 2)
    bearings = np.repeat([0.01, 2.0], 10)
    labels = np.array([0] * 4 + [1] * 6 + [1] + [0] * 9)
    assert order_outward(labels, bearings, distances, 2).tolist() == [[0, 1], [0, 0]]


def test_no_pixels_are_no_color() -> None:
    with pytest.raises(ValueError, match="at least 50 pixels"):
        learn_first(np.zeros((3, 3), np.uint8), np.zeros(3), np.zeros(3), ColorConfig())
