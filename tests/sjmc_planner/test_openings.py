"""Openings, candidates and costs of VFH+ against numbers worked by hand, and their laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjmc_planner.openings import candidates, cheapest, openings

NUM = 72
ALPHA = math.radians(5.0)
WEIGHTS = (5.0, 2.0, 2.0)


def blocked(*runs):
    """Return a histogram blocked from the first to the last sector of each run."""
    histogram = np.zeros(NUM, dtype=bool)
    for first, last in runs:
        histogram[np.arange(first, last + 1) % NUM] = True
    return histogram


def degrees(bearings):
    return sorted(np.degrees(bearings).round(6).tolist())


def test_openings_by_hand():
    assert openings(blocked((10, 20), (30, 60))).tolist() == [[21, 29], [61, 81]]


def test_an_opening_over_sector_0_is_one():
    assert openings(blocked((5, 68))).tolist() == [[69, 76]]


def test_a_closed_circle_has_no_opening_and_an_open_one_has_one():
    assert not len(openings(blocked((0, 71))))
    assert openings(blocked()).tolist() == [[0, 71]]


def test_a_narrow_opening_gives_its_middle():
    """Sectors 21 to 29, 9 of them: the middle is sector 25, 125 deg."""
    assert degrees(candidates(blocked((30, 92)), 0.0, 16.0)) == [125.0]


def test_a_wide_opening_gives_both_sides_and_the_goal_between_them():
    """Open from sector 61 (-55 deg) to 81 (45 deg): sides at sectors 69 and 73, -15 and 5 deg."""
    histogram = blocked((10, 60))
    assert degrees(candidates(histogram, math.radians(0.0), 16.0)) == [-15.0, 0.0, 5.0]
    assert degrees(candidates(histogram, math.radians(12.0), 16.0)) == [-15.0, 5.0]


def test_a_goal_on_the_far_side_of_the_circle_is_found_in_its_opening():
    histogram = blocked((-20, 20))
    found = candidates(histogram, math.radians(-170.0), 16.0)
    assert degrees(found) == [-170.0, -145.0, 145.0]


def test_with_nothing_blocked_the_goal_is_the_only_candidate():
    assert candidates(blocked(), 0.123, 16.0).tolist() == [pytest.approx(0.123)]


def test_the_cost_by_hand():
    """60 deg from the goal straight ahead beats 30 deg to the other side if it was the last one
    and the robot moves there: 5 * 60 + 0 + 0 = 300 against 5 * 30 + 2 * 90 + 2 * 90 = 510."""
    bearings = np.radians([60.0, -30.0])
    assert cheapest(bearings, 0.0, math.radians(60.0), math.radians(60.0), WEIGHTS) == 0
    assert cheapest(bearings, 0.0, 0.0, 0.0, WEIGHTS) == 1


def test_angles_of_the_cost_are_taken_around_the_back():
    bearings = np.radians([175.0, 150.0])
    goal = math.radians(-175.0)
    assert cheapest(bearings, goal, goal, goal, WEIGHTS) == 0


def test_without_a_candidate_none_is_cheapest():
    assert cheapest(np.zeros(0), 0.0, 0.0, 0.0, WEIGHTS) == -1


histograms = st.lists(st.booleans(), min_size=NUM, max_size=NUM).map(np.array)


@given(histograms)
def test_openings_hold_all_open_sectors_and_no_blocked_one(histogram):
    found = [np.arange(right, left + 1) % NUM for right, left in openings(histogram)]
    sectors = np.concatenate(found) if found else np.zeros(0, dtype=int)
    assert sorted(sectors.tolist()) == np.flatnonzero(~histogram).tolist()


@given(histograms, st.floats(-3.1, 3.1), st.integers(1, 30))
def test_no_candidate_is_blocked(histogram, goal, wide):
    for bearing in candidates(histogram, goal, float(wide)):
        sector = bearing / ALPHA
        around = {math.floor(sector + 1e-6) % NUM, math.ceil(sector - 1e-6) % NUM}
        assert not histogram[list(around)].all()


@given(histograms, st.floats(-3.1, 3.1), st.integers(1, 30))
def test_a_mirrored_histogram_has_mirrored_candidates(histogram, goal, wide):
    mirrored = histogram[(-np.arange(NUM)) % NUM]
    found = np.sort_complex(np.exp(1j * candidates(histogram, goal, float(wide))).round(9))
    other = np.sort_complex(np.exp(-1j * candidates(mirrored, -goal, float(wide))).round(9))
    assert np.abs(found - other) == pytest.approx(0.0, abs=1e-6)
