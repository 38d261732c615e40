"""The table of colors: the formula, in both orders of the channels, within the spans."""

from __future__ import annotations

import numpy as np
from painted_floors import GREEN, pixels

from floor_perception.color_model import has_color, learn
from floor_perception.color_table import classify, color_table
from floor_perception.config import ColorConfig

CONFIG = ColorConfig()


def test_the_table_says_what_the_formula_says_in_both_orders() -> None:
    color = learn(pixels(GREEN, 500), CONFIG)
    edges = np.arange(2, 256, 4)  # the middles of the table's steps
    cube = np.stack(np.meshgrid(edges, edges, edges, indexing="ij"), -1).reshape(-1, 3)
    expected = has_color(color, cube, CONFIG)
    rgb, bgr = (color_table(color, CONFIG, order) for order in ("rgb", "bgr"))
    assert ((rgb > 0) == expected).all() and expected.any()
    assert (bgr.reshape(64, 64, 64) == rgb.reshape(64, 64, 64).transpose(2, 1, 0)).all()


def test_only_the_spans_are_looked_up() -> None:
    color = learn(pixels(GREEN, 500), CONFIG)
    image = np.full((2, 6, 3), GREEN, dtype=np.uint8)
    always = np.zeros((2, 6), dtype=np.uint8)
    mask = np.full((2, 6), 7, dtype=np.uint8)
    spans = np.array([[1, 4], [0, 0]], dtype=np.int32)
    classify(image, color_table(color, CONFIG), spans, always, mask)
    assert mask.tolist() == [[7, 255, 255, 255, 7, 7], [7] * 6]
