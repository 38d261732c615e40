"""The floor's color through time: light is followed, obstacles and darkness are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from painted_floors import (
    GRAY,
    GREEN,
    Region,
    behind,
    painted,
    robot_body,
    upright_camera,
)

from floor_perception.color_model import FloorColor
from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector

CAMERA = upright_camera()
WALL = (behind(0.0, math.pi, 1.4), (200, 40, 40))
BODY = (robot_body(), GRAY)
LIGHT_FLOOR = (170, 170, 170)
LOOK_NS = 200_000_000
Color = tuple[int, int, int]


def picture(floor: Color, *regions: tuple[Region, Color], light: float = 1.0) -> np.ndarray:
    return painted(CAMERA, [WALL, *regions, BODY], 3.0, light, floor)


def look(detector: FloorDetector, image: np.ndarray, num: int, start_ns: int = 0) -> np.ndarray:
    """Show an image so many times; return the last ranges."""
    for k in range(1, num + 1):
        result = detector.detect(image, "rgb", start_ns + k * LOOK_NS)
    assert result is not None
    return result.scan.ranges


def color_after(floor: Color, steps: list[Color], half_width: float) -> tuple[FloorColor, ...]:
    """Return the color learned, and that after obstacles touched the robot for 30 s each."""
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(floor), 1)
    learned = detector.color
    for k, color in enumerate(steps):
        image = picture(floor, (behind(0.0, half_width, 0.1), color))
        look(detector, image, 150, (k + 1) * 200 * LOOK_NS)
    assert learned is not None and detector.color is not None
    return learned, detector.color


@pytest.mark.parametrize("half_width", [0.45 * math.pi, 0.6 * math.pi])
def test_a_darker_obstacle_of_the_floors_hue_makes_nothing_darker_the_floor(
    half_width: float,
) -> None:
    """Gray on gray: what is 0.44 as bright may be a shadow, what is 0.24 as bright never is."""
    learned, now = color_after(LIGHT_FLOOR, [(75, 75, 75)], half_width)
    assert now.low == pytest.approx(learned.low, rel=0.05)
    detector = FloorDetector(CAMERA, FloorDetectorConfig(), color=now)
    image = picture(LIGHT_FLOOR, (behind(0.0, 0.5, 0.1), (40, 40, 40)))
    ahead = np.abs(detector.detect(image, "rgb", 0).scan.angles) < 0.4
    assert np.isneginf(look(detector, image, 20)[ahead]).all()


def test_obstacles_that_differ_step_by_step_do_not_lead_the_color_away() -> None:
    steps = [(31, 115, 44), (38, 114, 48), (45, 112, 53), (55, 110, 60), (70, 105, 70)]
    learned, now = color_after(GREEN, steps, 0.45 * math.pi)
    sd = np.sqrt(np.diag(learned.cov))
    assert (np.abs(now.chroma - learned.chroma) < 1.5 * sd).all()
    assert (now.cov == learned.cov).all()


def test_a_lamp_that_fades_is_followed_with_a_wall_along_one_side() -> None:
    """A third of the ring is hidden: followed as far as the light is about what it was."""
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    learned = detector.color
    wall = (behind(0.0, 1.0, 0.1), (150, 110, 70))
    for k in range(1, 41):
        image = picture(GREEN, wall, light=1.0 - 0.25 * k / 40)
        detector.detect(image, "rgb", (1 + 5 * k) * LOOK_NS)
    assert detector.color.middle == pytest.approx(0.78 * learned.middle, rel=0.06)


def test_with_a_part_of_the_ring_hidden_the_color_stays_near_what_the_whole_ring_showed() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    learned = detector.color
    wall = (behind(0.0, 1.0, 0.1), (150, 110, 70))
    for k in range(1, 61):
        image = picture(GREEN, wall, light=1.0 - 0.6 * k / 60)
        detector.detect(image, "rgb", (1 + 5 * k) * LOOK_NS)
    assert detector.color.middle > learned.middle / 1.5
    assert "of the ring" in detector.tracker.reason


def test_a_lamp_that_fades_fast_is_followed_where_all_around_is_equally_bright() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    learned = detector.color
    dim = picture(GREEN, light=0.6)  # darker than a part of the floor in one light ever is
    ranges = look(detector, dim, 150, LOOK_NS)
    assert detector.color.middle == pytest.approx(0.6 * learned.middle, rel=0.05)
    assert (np.abs(ranges - 1.4) < 0.08).all()


@pytest.mark.parametrize(("part", "is_followed"), [(0.72, False), (0.9, True)])
def test_what_is_a_quarter_darker_than_the_rest_is_not_equally_bright(
    part: float, is_followed: bool
) -> None:
    """A thing of the floor's hue along a quarter of the ring, in a light that faded fast."""
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    learned = detector.color
    thing = (behind(0.0, 0.8, 0.1), tuple(round(part * v) for v in GREEN))
    look(detector, picture(GREEN, thing, light=0.6), 100, LOOK_NS)
    middle = (0.6 if is_followed else 1.0) * learned.middle
    assert detector.color.middle == pytest.approx(middle, rel=0.07)
    assert ("as bright as the floor was" in detector.tracker.reason) != is_followed


@pytest.mark.parametrize(("value", "words"), [(0, "too dark"), (255, "saturated")])
def test_in_the_dark_and_in_glare_nothing_is_learned_until_there_is_light(
    value: int, words: str
) -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    nothing = np.full((220, 256, 3), value, dtype=np.uint8)
    for k in range(4):
        assert detector.detect(nothing, "rgb", k * LOOK_NS) is None
    assert words in detector.tracker.reason
    assert (np.abs(look(detector, picture(GREEN), 1, 4 * LOOK_NS) - 1.4) < 0.08).all()


def test_darkness_after_light_is_never_free() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    dark = np.zeros((220, 256, 3), dtype=np.uint8)
    assert np.isneginf(look(detector, dark, 100, LOOK_NS)).all()
    assert (np.abs(look(detector, picture(GREEN), 1, 102 * LOOK_NS) - 1.4) < 0.08).all()


def test_a_slow_camera_learns_another_floor_only_after_several_looks() -> None:
    detector = FloorDetector(CAMERA, FloorDetectorConfig())
    look(detector, picture(GREEN), 1)
    other = picture((90, 80, 30))
    second_ns = 2_000_000_000
    for k in range(1, 5):
        assert np.isneginf(detector.detect(other, "rgb", k * second_ns).scan.ranges).all()
    assert np.isfinite(detector.detect(other, "rgb", 5 * second_ns).scan.ranges).all()
