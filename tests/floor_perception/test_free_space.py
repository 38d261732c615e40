"""Eq. 7 to 9 by hand; the published labelling and our counting agree cell for cell."""

from __future__ import annotations

import functools

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_floors import upright_camera

from floor_perception.config import TemplateConfig
from floor_perception.free_space import (
    floor_areas,
    free_ranges,
    free_ratios,
    labelled_areas,
    nearest_blocked,
    ratios_and_ranges,
)
from floor_perception.polar_template import PolarTemplate, make_template

EDGES = np.array([0.2, 0.5, 1.0, 2.0])
SHAPES = [(6, 32, True), (6, 32, False), (12, 45, False), (24, 180, False)]


@functools.cache
def template_of(num_rings: int, num_directions: int, has_borders: bool) -> PolarTemplate:
    config = TemplateConfig(
        num_rings=num_rings, num_directions=num_directions, has_borders=has_borders
    )
    return make_template(upright_camera(), config)


def random_mask(seed: int, share: float, blur: float) -> np.ndarray:
    """Return blobs and specks that cover about a share of the image."""
    noise = np.random.default_rng(seed).normal(size=(220, 256)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), blur)
    return np.where(smooth > np.quantile(smooth, 1.0 - share), 255, 0).astype(np.uint8)


def test_the_nearest_blocked_cell_is_counted_from_the_inside() -> None:
    ratios = np.array([[1.0, 0.9, 0.8], [1.0, 0.7, 1.0], [0.1, 1.0, 1.0]])
    assert nearest_blocked(ratios, 0.8).tolist() == [3, 1, 0]


def test_ranges_are_the_inner_borders_of_the_blocked_cells() -> None:
    ratios = np.array([
        [1.0, 1.0, 1.0], [1.0, 0.7, 1.0], [0.1, 1.0, 1.0], [1.0, np.nan, 0.0], [0.0, np.nan, 1.0],
        [np.nan, 1.0, 1.0], [1.0, 1.0, 0.0],
    ])  # fmt: skip
    expected = [np.inf, 0.5, -np.inf, np.nan, -np.inf, np.nan, 1.0]
    assert free_ranges(ratios, 0.8, EDGES) == pytest.approx(np.array(expected), nan_ok=True)


def test_a_floor_without_anything_is_free_to_the_horizon() -> None:
    template = template_of(6, 32, True)
    mask = np.full((220, 256), 255, dtype=np.uint8)
    assert (floor_areas(mask, template) == template.areas).all()
    ranges = free_ranges(free_ratios(template.areas, template), 1.0, template.edges)
    assert np.isposinf(ranges).all()


def test_no_floor_at_all_is_nearer_than_the_first_ring() -> None:
    template = template_of(6, 32, True)
    none = floor_areas(np.zeros((220, 256), dtype=np.uint8), template)
    assert np.isneginf(free_ranges(free_ratios(none, template), 0.1, template.edges)).all()


@settings(max_examples=15)
@given(
    st.integers(0, 10_000), st.floats(0.1, 0.95), st.sampled_from([0.3, 1.0, 4.0]),
    st.sampled_from(SHAPES),
)  # fmt: skip
def test_counting_equals_labelling_cell_for_cell(
    seed: int, share: float, blur: float, shape: tuple[int, int, bool]
) -> None:
    template, mask = template_of(*shape), random_mask(seed, share, blur)
    assert floor_areas(mask, template).tolist() == labelled_areas(mask, template).tolist()


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.floats(0.3, 0.99), st.floats(0.05, 1.0), st.sampled_from(SHAPES))
def test_one_pass_equals_the_formulas(
    seed: int, share: float, free_share: float, shape: tuple[int, int, bool]
) -> None:
    template = template_of(*shape)
    floor = floor_areas(random_mask(seed, share, 4.0), template)
    ratios, ranges = ratios_and_ranges(floor, template, free_share)
    expected = free_ratios(floor, template)
    np.testing.assert_array_equal(ratios, expected)
    np.testing.assert_array_equal(ranges, free_ranges(expected, free_share, template.edges))


def test_more_floor_never_shortens_a_range() -> None:
    template = template_of(24, 180, False)
    small, large = random_mask(3, 0.5, 4.0), random_mask(3, 0.8, 4.0)
    assert (large >= small).all()
    less, more = (
        free_ranges(free_ratios(floor_areas(m, template), template), 0.6, template.edges)
        for m in (small, large)
    )
    assert (more >= less).all()


def test_a_direction_with_a_hidden_cell_before_the_obstacle_says_nothing() -> None:
    is_hidden = np.zeros((220, 256), dtype=bool)
    is_hidden[:, 128:] = True
    template = make_template(upright_camera(), TemplateConfig(), is_hidden)
    mask = np.full((220, 256), 255, dtype=np.uint8)
    _, ranges = ratios_and_ranges(floor_areas(mask, template), template, 0.6)
    angles = template.bearings
    assert np.isnan(ranges[np.abs(angles) < 1.4]).all()
    assert np.isposinf(ranges[np.abs(angles) > 1.8]).all()
