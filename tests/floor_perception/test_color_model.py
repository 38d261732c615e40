"""The floor's color: learned by majority, followed, kept in files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_floors import BROWN, GRAY, GREEN, WHITE, pixels

from floor_perception.color_files import load_color, save_color
from floor_perception.color_model import (
    FloorColor,
    chromaticity,
    differs,
    followed,
    has_color,
    learn,
    response_part,
)
from floor_perception.color_table import color_table
from floor_perception.config import ColorConfig

CONFIG = ColorConfig()


def test_a_shadow_leaves_chromaticity_as_it_is() -> None:
    colors = np.array([[20, 100, 40], [10, 50, 20], [0, 0, 0]])
    assert chromaticity(colors)[0] == pytest.approx([0.125, 0.625])
    assert chromaticity(colors)[1] == pytest.approx(chromaticity(colors)[0])
    assert chromaticity(colors)[2] == pytest.approx([1 / 3, 1 / 3])


def test_the_densest_color_is_learned_from_a_mixture() -> None:
    mixed = np.concatenate((pixels(GREEN, 600), pixels(WHITE, 250, 1), pixels(BROWN, 150, 2)))
    color = learn(mixed, CONFIG, share=0.5)
    assert color.chroma == pytest.approx(chromaticity(np.array(GREEN)), abs=0.01)
    assert color.middle == pytest.approx(sum(GREEN), rel=0.03)
    assert color.low < color.middle < color.high


def test_no_color_is_learned_where_none_prevails() -> None:
    mixed = np.concatenate([pixels(c, 300, k) for k, c in enumerate((GREEN, WHITE, BROWN))])
    with pytest.raises(ValueError, match="share a color"):
        learn(mixed, CONFIG, share=0.5)
    with pytest.raises(ValueError, match="at least 50 pixels"):
        learn(mixed[:10], CONFIG)


@pytest.mark.parametrize("other", [WHITE, GRAY, BROWN, (0, 0, 0), (255, 255, 255)])
def test_other_colors_are_not_the_floors(other: tuple[int, int, int]) -> None:
    color = learn(pixels(GREEN, 500), CONFIG)
    assert has_color(color, pixels(GREEN, 500, 5), CONFIG).mean() > 0.99
    assert has_color(color, pixels(tuple(v // 2 for v in GREEN), 500, 5), CONFIG).mean() > 0.95
    assert not has_color(color, pixels(other, 500, 6), CONFIG).any()


@settings(max_examples=30)
@given(st.floats(0.01, 1.0))
def test_a_color_followed_goes_a_part_of_the_way_and_keeps_its_spread(part: float) -> None:
    old, new = learn(pixels(GREEN, 500), CONFIG), pixels(BROWN, 500)
    now = followed(old, new, part)
    target = np.median(chromaticity(new), axis=0)
    assert now.chroma == pytest.approx(old.chroma + part * (target - old.chroma))
    assert now.middle == pytest.approx(old.middle * (330.0 / old.middle) ** part, rel=0.01)
    assert now.low / now.middle == pytest.approx(old.low / old.middle)
    assert now.high / now.middle == pytest.approx(old.high / old.middle)
    assert (now.cov == old.cov).all()
    assert differs(old, followed(old, new, 1.0)) and not differs(old, old)


def test_what_is_the_smaller_part_of_the_pixels_hardly_moves_the_color() -> None:
    old = learn(pixels(GREEN, 500), CONFIG)
    mixed = np.concatenate((pixels(GREEN, 550, 1), pixels((13, 60, 20), 450, 2)))
    now = followed(old, mixed, 1.0)
    assert now.middle == pytest.approx(old.middle, rel=0.05)
    assert now.chroma == pytest.approx(old.chroma, abs=0.02)


@pytest.mark.parametrize(
    ("value", "words"), [(0, "too dark"), (9, "too dark"), (254, "saturated"), (255, "saturated")]
)
def test_no_color_is_learned_in_the_dark_or_where_all_is_saturated(value: int, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        learn(np.full((100, 3), value, dtype=np.uint8), CONFIG)


def test_a_floor_partly_black_is_learned_and_black_is_not_floor() -> None:
    mixed = np.concatenate((pixels((20, 60, 20), 950), np.zeros((50, 3), dtype=np.uint8)))
    color = learn(mixed, CONFIG)
    assert np.isfinite([color.low, color.middle, color.high, *color.chroma]).all()
    assert not differs(color, followed(color, mixed, 1e-9))
    assert color_table(color, CONFIG)[0] == 0
    black = FloorColor(color.chroma, color.cov, 1.0, 100.0, 200.0)  # as deep shadows would have it
    assert not has_color(black, np.array([[2, 6, 2]]), CONFIG).any()
    assert differs(color, black)


def test_a_response_is_two_thirds_through_after_its_time_constant() -> None:
    assert response_part(5.0, 5.0) == pytest.approx(0.632, abs=1e-3)
    assert response_part(1.0, 0.0) == 0.0
    assert response_part(-1.0, 5.0) == 0.0


def test_a_color_comes_back_from_its_file(tmp_path: Path) -> None:
    color = learn(pixels(GREEN, 500), CONFIG)
    save_color(color, tmp_path / "green.yaml")
    back = load_color(tmp_path / "green.yaml")
    assert back.chroma == pytest.approx(color.chroma) and back.cov == pytest.approx(color.cov)
    assert (back.low, back.middle, back.high) == (color.low, color.middle, color.high)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("kind: shoe", "kind: floor_color"),
        ("kind: floor_color\nchroma: [1, 2]", "keys must be"),
        ("{", "not YAML"),
        ("kind: floor_color\nchroma: [a, 2]\ncov: [[1, 0], [0, 1]]\nlow: 1\nmiddle: 2\nhigh: 3",
         "must be numbers"),
        ("kind: floor_color\nchroma: [0, 0]\ncov: [[1, 0], [0, -1]]\nlow: 1\nmiddle: 2\nhigh: 3",
         "cov must be positive"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_color_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        load_color(path)
