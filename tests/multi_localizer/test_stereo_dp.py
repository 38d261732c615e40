import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multi_localizer.stereo_dp import match_monotone


def match(costs, step):
    out = np.empty(costs.shape[:2], dtype=np.float32)
    match_monotone(0, len(costs), costs, np.int32(step), out)
    return out


def costs_of(disparities, num, other=100):
    """Cost 0 at one disparity a column."""
    costs = np.full((1, len(disparities), num), other, dtype=np.uint8)
    costs[0, np.arange(len(disparities)), disparities] = 0
    return costs


def sum_of_path(costs, path, step):
    """The sum of a path; infinite where the order reverses."""
    rises = np.diff(path)
    if np.any(rises > 1):
        return np.inf
    return int(costs[np.arange(len(path)), path].sum()) + step * int(np.abs(rises).sum())


def test_a_path_of_no_cost_that_keeps_the_order_is_found():
    path = [2] * 6 + [3, 4, 5] + [5] * 6 + [1] * 4
    assert match(costs_of(path, 8), step=20)[0].tolist() == path


def test_a_near_edge_is_drawn_out_over_what_it_hides():
    path = [2] * 8 + [5] * 8
    found = match(costs_of(path, 8), step=20)[0]
    assert found.max() == 5 and np.diff(found).max() == 1
    assert np.sum(found != path) == 2  # two columns of the ramp lie on neither surface


def test_what_stands_in_the_other_order_cannot_be_matched():
    # A thin near pole before a far wall: in the right image it stands left of what is left of it.
    found = match(costs_of([1] * 8 + [6] * 2 + [1] * 8, 8), step=60)[0]
    assert not np.any(found[8:10] == 6)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_no_path_is_better(seed, step):
    costs = np.random.default_rng(seed).integers(0, 60, (1, 5, 4), dtype=np.uint8)
    found = match(costs, step)[0].astype(int)
    sums = [
        sum_of_path(costs[0], np.array(path), step)
        for path in itertools.product(range(4), repeat=5)
    ]
    assert sum_of_path(costs[0], found, step) == min(sums)
