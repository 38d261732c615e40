import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multi_localizer.stereo_winners import pick_winners, refine


def pick(sums, max_difference=1, first_right=0):
    width, num = sums.shape
    out = np.empty(width, dtype=np.float32)
    memory = np.empty(width + num, dtype=np.uint32)
    pick_winners(sums.astype(np.uint16), max_difference, first_right, memory, out)
    return out


def sums_of(disparities, num=8):
    """Sum 0 at one disparity a column, and 100 elsewhere."""
    sums = np.full((len(disparities), num), 100)
    sums[np.arange(len(disparities)), disparities] = 0
    return sums


def test_of_two_that_want_one_right_pixel_the_better_one_gets_it():
    # Columns 4 to 7 want right pixel 3; that of 7 costs least, and 6 is nearly as near as it.
    sums = sums_of([1, 1, 1, 1, 1, 2, 3, 4])
    sums[[4, 5, 6], [1, 2, 3]] = 9
    found = pick(sums)
    assert np.isnan(found[[0, 4, 5]]).all()  # 0: its partner is outside
    assert found[[1, 2, 3, 6, 7]].tolist() == [1, 1, 1, 3, 4]


def test_partners_in_the_blank_border_are_not_seen():
    found = pick(sums_of([2] * 9), first_right=3)
    assert np.isnan(found[:5]).all()
    assert found[5:].tolist() == [2] * 4


def test_a_winner_lies_between_pixels_toward_the_lesser_neighbor():
    sums = np.full((8, 6), 100)
    sums[:, 1:4] = [40, 10, 20]
    assert pick(sums)[4:].tolist() == pytest.approx([2 + 0.5 * 20 / 30] * 4)
    sums[:, 1:4] = [20, 10, 20]
    assert pick(sums)[4:].tolist() == [2.0] * 4


def test_equal_sums_give_the_first():
    assert pick(np.full((4, 3), 7))[2:].tolist() == [0, 0]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3), st.integers(0, 4))
def test_winners_are_those_of_a_plain_search(seed, max_difference, first_right):
    sums = np.random.default_rng(seed).integers(0, 630, (9, 5))
    found = pick(sums, max_difference, first_right)
    for x in range(9):
        d = int(np.argmin(sums[x]))
        partner = x - d
        wanted = [(sums[partner + e, e], e) for e in range(5) if partner >= 0 and partner + e < 9]
        is_seen = partner >= first_right and abs(min(wanted)[1] - d) <= max_difference
        assert np.isnan(found[x]) == (not is_seen)
        assert not is_seen or abs(found[x] - d) <= 0.5


def test_whole_disparities_move_to_the_least_cost_and_holes_stay():
    costs = np.full((1, 4, 6), 90, dtype=np.uint8)
    costs[0, :, 1:4] = [40, 10, 20]
    found = np.array([[2.0, np.nan, 3.0, 0.0]], dtype=np.float32)
    refine(0, 1, costs, found)
    assert found[0, 0] == pytest.approx(2 + 0.5 * 20 / 30)
    assert np.isnan(found[0, 1])
    assert found[0, 2:].tolist() == [3.0, 0.0]  # 3 is not the least, 0 has one neighbor only
