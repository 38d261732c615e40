import numpy as np
import pytest

from multi_localizer.stereo_cost import (
    MAX_COLOR_COST,
    OUTSIDE_COST,
    census,
    first_column,
    matching_costs,
)


def noise(shape, seed=0):
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def test_census_of_one_bright_pixel_has_all_its_neighbors_darker_and_theirs_none():
    gray = np.full((9, 11), 10, dtype=np.uint8)
    gray[4, 5] = 20
    codes = census(gray)
    assert int(codes[4, 5]).bit_count() == 30  # every second pixel of 7 x 9, itself left out
    codes[4, 5] = 0
    assert not codes.any()


def test_census_does_not_see_brightness_and_contrast():
    gray = noise((20, 30)) // 4
    assert np.array_equal(census(gray), census(3 * gray + 40))


@pytest.mark.parametrize("shape", [(12, 40), (12, 40, 3)])
def test_cost_is_zero_exactly_at_the_shift(shape):
    right = noise(shape)
    left = np.roll(right, 5, axis=1)
    costs = matching_costs(left, right, 16)
    inner = costs[:, 16:-6]
    assert costs.shape == (12, 40, 16)
    assert not inner[:, :, 5].any()
    assert np.delete(inner, 5, axis=2).mean() > 20


def test_color_cost_by_hand():
    left = np.full((1, 20, 3), 100, dtype=np.uint8)
    right = left.copy()
    right[..., 0] += 10
    right[..., 2] -= 6
    # (10 + 0 + 6) * 11 / 32, rounded down; no census bit is set in even images
    assert np.unique(matching_costs(left, right, 16)[:, 15:]).tolist() == [5]


def test_color_cost_is_cut_off():
    dark, bright = np.zeros((2, 20), np.uint8), np.full((2, 20), 255, np.uint8)
    assert np.unique(matching_costs(dark, bright, 16)[:, 15:]).tolist() == [MAX_COLOR_COST]


def test_what_lies_outside_of_the_right_image_costs_the_same_everywhere():
    left, right = noise((4, 24), 1), noise((4, 24), 2)
    costs = matching_costs(left, right, 16)
    assert np.unique(costs[:, 3, 4:]).tolist() == [OUTSIDE_COST]
    assert np.unique(costs[:, 3, :4]).size > 4


def test_an_image_begins_where_its_columns_differ():
    image = np.random.default_rng(0).integers(0, 256, (5, 20), dtype=np.uint8)
    assert first_column(image) == 0
    assert first_column(np.pad(image, ((0, 0), (7, 0)), mode="edge")) == 7
    assert first_column(np.zeros((5, 20), np.uint8)) == 0
