"""Directions that end in glare are not seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from painted_floors import BROWN, GRAY, WHITE, behind, painted, robot_body, upright_camera

from floor_perception.config import ColorConfig, FloorDetectorConfig, TemplateConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.glare import GlareFinder
from floor_perception.polar_template import make_template

CAMERA = upright_camera()
GLARE = (behind(0.0, 0.3, 0.5), (255, 255, 255))
PAPER = (behind(2.0, 0.3, 0.5), WHITE)
BLOCK = (behind(-2.0, 0.3, 0.5), BROWN)
BODY = (robot_body(), GRAY)


def ranges_of(*regions: tuple, glare_share: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    config = FloorDetectorConfig()
    if glare_share is not None:
        config = replace(config, color=ColorConfig(glare_share=glare_share))
    image = painted(CAMERA, [*regions, BODY])
    scan = FloorDetector(CAMERA, config).detect(image, "rgb", 0).scan
    return scan.angles, scan.ranges


def near(angles: np.ndarray, bearing: float) -> np.ndarray:
    return np.abs(np.angle(np.exp(1j * (angles - bearing)))) < 0.25


def test_glare_is_not_seen_and_things_that_are_white_are_obstacles() -> None:
    angles, ranges = ranges_of(GLARE, PAPER, BLOCK)
    assert np.isnan(ranges[near(angles, 0.0)]).all()
    for bearing in (2.0, -2.0):
        assert (np.abs(ranges[near(angles, bearing)] - 0.5) < 0.05).all()
    assert np.isposinf(ranges[near(angles, math.pi)]).all()


def test_glare_behind_an_obstacle_hides_nothing() -> None:
    angles, ranges = ranges_of((behind(0.0, 0.4, 0.7), (255, 255, 255)), (
        lambda x, y: (np.hypot(x, y) >= 0.4) & (np.hypot(x, y) < 0.7), BROWN,
    ))  # fmt: skip
    assert (np.abs(ranges[near(angles, 0.0)] - 0.4) < 0.05).all()


def test_a_share_of_one_takes_glare_for_an_obstacle() -> None:
    angles, ranges = ranges_of(GLARE, glare_share=1.0)
    assert (np.abs(ranges[near(angles, 0.0)] - 0.5) < 0.05).all()


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_more_than_the_share_of_what_is_not_floor_must_be_saturated(share: float) -> None:
    """Half of one cell is no floor; the share of that half, to a pixel, is the border."""
    template = make_template(CAMERA, TemplateConfig(num_rings=6, num_directions=32))
    way, ring = 16, 3
    rows, columns = np.nonzero(template.cells == way * 6 + ring)
    ratios = np.ones((32, 6))
    ratios[way, ring:] = 0.5
    num = int(share * 0.5 * len(rows))
    assert num >= 10

    def found(num_saturated: int, value: int) -> list[int]:
        image = np.full((220, 256, 3), 100, dtype=np.uint8)
        image[rows[:num_saturated], columns[:num_saturated]] = value
        return np.flatnonzero(GlareFinder(template).unseen(image, ratios, 0.6, share)).tolist()

    assert found(num, 255) == []
    assert found(num + 1, 255) == [way]
    assert found(num + 1, 252) == [way]
    assert found(num + 1, 251) == []
