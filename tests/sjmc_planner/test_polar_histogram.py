"""The first three stages of VFH+ against numbers worked by hand, and their laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjmc_planner.polar_histogram import (
    binary_histogram,
    mask_limits,
    masked_histogram,
    primary_histogram,
)

NUM = 72
ALPHA = math.radians(5.0)


def primary(points, certainty, enlarged_by=0.5, reach=2.0, near_weight=3.0, num=NUM):
    cells = np.array(points, dtype=float).reshape(-1, 2)
    return primary_histogram(
        cells, np.array(certainty, dtype=float), enlarged_by, reach, near_weight, num
    )


def test_one_sure_cell_ahead_by_hand():
    """At 1 m enlarged by 0.5 m: asin(0.5) = 30 deg to each side, a - b d^2 = 3 - 0.5 = 2.5."""
    histogram = primary([(1.0, 0.0)], [1.0])
    sectors = np.flatnonzero(histogram)
    assert sectors.tolist() == [*range(7), *range(66, 72)]
    assert histogram[sectors] == pytest.approx(np.full(13, 2.5))


def test_certainty_counts_squared_and_the_border_of_the_window_counts_one():
    histogram = primary([(0.0, 2.0)], [0.4])
    assert histogram[18] == pytest.approx(0.16)
    assert primary([(0.0, 2.0)], [1.0])[18] == pytest.approx(1.0)


def test_cells_of_one_sector_add_up():
    """At d^2 = 1 and 2.25 on the left: 2.5 and 3 - 1.125 = 1.875."""
    histogram = primary([(0.0, 1.0), (0.0, 1.5)], [1.0, 1.0])
    assert histogram[18] == pytest.approx(4.375)


def test_a_cell_beyond_the_window_does_not_count():
    assert not primary([(2.01, 0.0)], [1.0]).any()


def test_a_cell_within_the_robots_own_circle_blocks_the_half_plane_towards_it():
    sectors = np.flatnonzero(primary([(0.3, 0.0)], [1.0]))
    assert sectors.tolist() == [*range(19), *range(54, 72)]


def test_hysteresis_by_hand():
    low, high = 0.3, 0.6
    densities = np.array([0.1, 0.45, 0.45, 0.9, 0.3, 0.6])
    before = np.array([True, True, False, False, True, False])
    after = binary_histogram(densities, before, low, high)
    assert after.tolist() == [False, True, False, True, True, False]


def test_a_cell_beside_the_way_closes_what_lies_beyond_it_by_hand():
    """Circles of 1 m, enlarged 0.5 m: (1, 1) is 1 m from the left circle's middle (0, 1) and
    sqrt(5) m from the right one's (0, -1)."""
    right, left = mask_limits(np.array([[1.0, 1.0]]), 0.0, 1.0, 0.5)
    assert right == -math.pi and left == pytest.approx(math.pi / 4)


def test_a_cell_just_outside_of_both_turning_circles_closes_nothing():
    for y, is_closed in ((2.51, False), (2.49, True)):
        _, left = mask_limits(np.array([[0.0, y]]), 0.0, 1.0, 0.5)
        assert (left < math.pi) == is_closed


def test_a_robot_that_turns_where_it_is_can_turn_anywhere():
    limits = mask_limits(np.array([[0.4, 0.4]]), 0.0, 0.0, 0.5)
    assert limits == (-math.pi, math.pi)
    is_blocked = np.arange(NUM) % 7 == 0
    assert (masked_histogram(is_blocked, 0.3, limits) == is_blocked).all()


def test_the_mask_turns_with_the_heading():
    """The same scene a quarter further to the left has the same limits from the heading."""
    points = np.array([[1.0, 1.0], [0.8, -1.2]])
    ahead = mask_limits(points, 0.0, 1.0, 0.5)
    turned = mask_limits(np.column_stack((-points[:, 1], points[:, 0])), math.pi / 2, 1.0, 0.5)
    assert turned == pytest.approx(ahead)


def test_masked_sectors_by_hand():
    """Heading 10 deg, from 20 deg right of it to 45 deg left of it: -10 to 55 deg."""
    limits = math.radians(-20.0), math.radians(45.0)
    is_blocked = np.zeros(NUM, dtype=bool)
    is_blocked[4] = True
    masked = masked_histogram(is_blocked, math.radians(10.0), limits)
    assert np.flatnonzero(~masked).tolist() == [0, 1, 2, 3, *range(5, 12), 70, 71]


coordinate = st.floats(-2.5, 2.5).filter(lambda v: abs(v) > 1e-3)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=20))
def test_a_mirrored_scene_has_a_mirrored_histogram(points):
    cells = np.array(points)
    ones = np.ones(len(cells))
    histogram = primary(cells, ones)
    mirrored = primary(cells * (1.0, -1.0), ones)
    assert mirrored[(-np.arange(NUM)) % NUM] == pytest.approx(histogram)


@given(
    st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=20),
    st.floats(-3.0, 3.0), st.floats(0.0, 2.0),
)  # fmt: skip
def test_mirrored_cells_have_mirrored_limits(points, heading, turn_radius):
    cells = np.array(points)
    right, left = mask_limits(cells, heading, turn_radius, 0.3)
    mirrored = mask_limits(cells * (1.0, -1.0), -heading, turn_radius, 0.3)
    assert mirrored == pytest.approx((-left, -right))


@given(
    st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=8),
    st.floats(-3.1, 3.1),
)
def test_whatever_is_in_the_way_of_a_straight_drive_blocks_its_sector(points, bearing):
    """Eq. 4: a sector without density is a straight way that stays clear of every cell."""
    cells = np.array(points)
    k = round(bearing / ALPHA) % NUM
    along = cells @ (math.cos(k * ALPHA), math.sin(k * ALPHA))
    aside2 = (cells**2).sum(axis=1) - along**2
    is_inside = (cells**2).sum(axis=1) < 4.0
    is_in_the_way = is_inside & (along > 1e-6) & (aside2 < (0.5 - 1e-6) ** 2)
    if is_in_the_way.any():
        assert primary(cells, np.ones(len(cells)))[k] > 0.0


def test_straight_behind_is_reached_by_either_side():
    is_blocked = np.zeros(NUM, dtype=bool)
    for limits in ((-math.pi, 0.5), (-0.5, math.pi)):
        assert not masked_histogram(is_blocked, 0.0, limits)[36]
    assert masked_histogram(is_blocked, 0.0, (-0.5, 0.5))[36]
