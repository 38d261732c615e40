"""VFF's forces and VFH's histogram and valleys, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjmc_planner.vff import damped_share, repulsion
from sjmc_planner.vfh import density, smoothed, valley_direction

NUM = 72
FAR = np.array([[10.0, 0.0]])


def test_a_sure_cell_pushes_by_the_square_of_its_distance():
    """0.01 m^2 at 2 m on the left: 0.01 / 4 to the right."""
    push = repulsion(np.array([[0.0, 2.0]]), np.ones(1), 3.0, 0.1, 0.01)
    assert push == pytest.approx((0.0, -0.0025))
    half = repulsion(np.array([[0.0, 2.0]]), np.array([0.5]), 3.0, 0.1, 0.01)
    assert half == pytest.approx((0.0, -0.00125))


def test_pushes_add_up_and_cancel():
    both = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0]])
    assert repulsion(both, np.ones(3), 3.0, 0.1, 0.01) == pytest.approx((-0.01, 0.0))


def test_a_cell_pushes_no_harder_than_from_the_robots_circle_and_not_from_beyond_the_window():
    assert repulsion(np.array([[0.1, 0.0]]), np.ones(1), 3.0, 0.5, 0.01) == pytest.approx(
        (-0.04, 0.0)
    )
    assert repulsion(FAR, np.ones(1), 3.0, 0.5, 0.01) == (0.0, 0.0)


def test_speed_falls_against_the_push_by_its_share_of_the_pull():
    assert damped_share(0.0, (0.0, 0.0)) == 1.0
    assert damped_share(0.0, (-2.0, 0.0)) == pytest.approx(0.0)
    assert damped_share(0.0, (-0.5, 0.0)) == pytest.approx(0.5)
    assert damped_share(0.0, (0.0, 2.0)) == pytest.approx(1.0)
    assert damped_share(math.pi / 2, (0.0, -0.25)) == pytest.approx(0.75)


def test_density_by_hand():
    """At half of the window: 0.5; less sure by the square; beyond the window nothing."""
    points = np.array([[1.0, 0.0], [0.0, 1.0], [3.0, 0.0]])
    found = density(points, np.array([1.0, 0.5, 1.0]), 2.0, NUM)
    assert found[0] == pytest.approx(0.5) and found[18] == pytest.approx(0.125)
    assert np.count_nonzero(found) == 2


def test_smoothing_by_hand():
    """l = 2: weights 1, 2, 3, 2, 1 over 5."""
    histogram = np.zeros(NUM)
    histogram[0] = 5.0
    assert smoothed(histogram, 2)[[-3, -2, -1, 0, 1, 2, 3]] == pytest.approx([0, 1, 2, 3, 2, 1, 0])


def open_between(*runs):
    histogram = np.zeros(NUM, dtype=bool)
    for first, last in runs:
        histogram[np.arange(first, last + 1) % NUM] = True
    return histogram


def test_valleys_by_hand():
    """In degrees of 5 a sector; s_max 18 sectors."""
    everything = open_between((0, 71))
    assert valley_direction(everything, 0.3, 18) == 0.3
    wide = open_between((-20, 20))
    assert valley_direction(wide, math.radians(10.0), 18) == math.radians(10.0)
    # The goal is 5 sectors from the border: half of 18 is kept from it.
    assert valley_direction(wide, math.radians(75.0), 18) == pytest.approx(math.radians(55.0))
    narrow = open_between((4, 10))
    assert valley_direction(narrow, 0.0, 18) == pytest.approx(math.radians(35.0))
    assert valley_direction(open_between(), 0.0, 18) is None


def test_the_valley_nearest_the_goal_is_taken():
    two = open_between((10, 12), (-9, -7))
    assert valley_direction(two, 0.0, 18) == pytest.approx(math.radians(-40.0))
