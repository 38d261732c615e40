import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multi_localizer.stereo_intervals import (
    cut_row,
    find_hidden,
    go_on,
    match_interval,
    match_intervals,
)


def ends_of(values, threshold):
    colors = np.asarray(values, dtype=np.uint8)[:, None]
    ends = np.empty(len(colors), dtype=np.int32)
    return ends[: cut_row(colors, threshold, ends)].tolist()


def match(colors, costs, threshold=20, stretch=50, worst=60.0):
    out = np.empty(costs.shape[:2], dtype=np.float32)
    is_hidden = np.empty(out.shape, dtype=bool)
    match_intervals(0, len(out), costs, colors, threshold, np.int32(stretch), worst, out, is_hidden)
    return out, is_hidden


def test_a_sharp_edge_is_one_cut():
    assert ends_of([10] * 5 + [90] * 5, 20) == [5, 10]


def test_a_change_to_darker_is_cut_as_one_to_brighter():
    assert ends_of([90] * 5 + [60] + [10] * 4, 20) == [6, 10]
    assert ends_of([10] * 5 + [40] + [90] * 4, 20) == [6, 10]
    assert ends_of([90, 85, 80, 75], 20) == [4]


def test_even_color_and_slow_change_are_not_cut():
    assert ends_of([50] * 9, 20) == [9]
    assert ends_of(range(0, 90, 9), 20) == [10]


def test_a_blurred_edge_is_cut_once_where_it_is_steepest():
    assert ends_of([10, 10, 10, 20, 60, 80, 90, 90, 90], 15) == [4, 9]


@given(st.lists(st.integers(0, 255), min_size=1, max_size=40), st.integers(1, 255))
def test_intervals_cover_the_row_once(values, threshold):
    ends = ends_of(values, threshold)
    assert ends[-1] == len(values)
    assert all(a < b for a, b in itertools.pairwise([0, *ends]))


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 80), st.integers(1, 3))
def test_no_path_through_an_interval_is_better(seed, stretch, num):
    costs = np.random.default_rng(seed).integers(0, 60, (5, num), dtype=np.uint8)
    sums, out = np.empty((5, num), np.int32), np.zeros(5, np.float32)
    score = match_interval(0, 5, costs, np.int32(stretch), sums, out)

    def cost(path):
        steps = [abs(a - b) for a, b in itertools.pairwise(path)]
        total = sum(int(costs[x, d]) for x, d in enumerate(path)) + stretch * sum(steps)
        return total if max(steps) <= 1 else np.inf

    found = out.astype(int).tolist()
    assert cost(found) == min(cost(path) for path in itertools.product(range(num), repeat=5))
    assert score == sum(int(costs[x, d]) for x, d in enumerate(found))  # stretching is no misfit


def test_two_intervals_may_stand_in_the_other_order():
    # Far wall, near pole, far wall: the pole's partners lie left of those of the wall before it.
    colors = np.repeat(np.array([40, 200, 40], np.uint8), [8, 2, 8])[None, :, None]
    costs = np.full((1, 18, 8), 100, dtype=np.uint8)
    costs[0, :8, 1] = costs[0, 8:10, 6] = costs[0, 10:, 1] = 0
    costs[0, 3:5, 1] = 100  # behind the pole for the right camera
    found, is_hidden = match(colors, costs)
    assert found[0].tolist() == [1] * 8 + [6] * 2 + [1] * 8
    assert not is_hidden.any()
    columns = np.arange(18) - found[0]
    assert columns[8] < columns[7]


def test_a_hidden_interval_goes_on_as_the_one_before_it():
    colors = np.repeat(np.array([40, 120, 200], np.uint8), [6, 3, 6])[None, :, None]
    costs = np.full((1, 15, 8), 100, dtype=np.uint8)
    costs[0, :6, 2] = costs[0, 9:, 5] = 0
    found, is_hidden = match(colors, costs)
    assert found[0].tolist() == [2] * 9 + [5] * 6
    assert is_hidden[0].tolist() == [False] * 6 + [True] * 3 + [False] * 6


def hidden(disparities, ends, scores, worst=60.0):
    found = np.zeros(len(disparities), dtype=bool)
    find_hidden(
        np.array(disparities, np.float32), np.array(ends, np.int32), np.array(scores), worst,
        np.empty(len(found), np.int32), found,
    )  # fmt: skip
    return found.tolist()


def test_of_two_intervals_that_want_the_same_right_pixels_the_worse_one_is_hidden():
    # Columns 4 to 6 and 7 to 9 want right pixels 4 to 6.
    disparities, ends = [0] * 7 + [3] * 3, [4, 7, 10]
    assert hidden(disparities, ends, [5.0, 20.0, 9.0]) == [False] * 4 + [True] * 3 + [False] * 3
    assert hidden(disparities, ends, [5.0, 9.0, 20.0]) == [False] * 7 + [True] * 3


def test_an_interval_may_lose_half_of_its_right_pixels():
    disparities, ends = [0] * 6 + [2] * 4, [2, 6, 10]  # both want 4 and 5
    assert hidden(disparities, ends, [1.0, 20.0, 9.0]) == [False] * 10


def test_an_interval_whose_partners_lie_outside_is_hidden():
    assert hidden([2, 2, 2, 2, 2], [3, 5], [1.0, 1.0]) == [True] * 3 + [False] * 2


def test_a_bad_score_hides_whatever_the_others_want():
    assert hidden([0, 0, 0, 0], [2, 4], [60.0, 60.5]) == [False, False, True, True]


def test_what_is_hidden_at_the_start_takes_what_follows():
    row = np.array([9, 9, 4, 3, 9], dtype=np.float32)
    go_on(row, np.array([True, True, False, False, True]))
    assert row.tolist() == [4, 4, 4, 3, 3]


def test_where_all_is_hidden_nothing_is_known():
    row = np.array([9, 9], dtype=np.float32)
    go_on(row, np.array([True, True]))
    assert np.isnan(row).all()


def test_rows_do_not_depend_on_each_other():
    rng = np.random.default_rng(0)
    colors = rng.integers(0, 256, (4, 30, 3), dtype=np.uint8)
    costs = rng.integers(0, 100, (4, 30, 16), dtype=np.uint8)
    together, _ = match(colors, costs)
    alone = np.vstack([match(colors[y : y + 1], costs[y : y + 1])[0] for y in range(4)])
    assert np.array_equal(together, alone, equal_nan=True)
