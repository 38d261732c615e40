import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multi_localizer.stereo_dp import match_monotone


def match(costs, occlusion):
    out = np.empty(costs.shape[:2], dtype=np.float32)
    match_monotone(0, len(costs), costs, np.int32(occlusion), out)
    return out


def costs_of(disparities, num, other=100):
    """Cost 0 at one disparity a column; `None` has none."""
    costs = np.full((1, len(disparities), num), other, dtype=np.uint8)
    for x, d in enumerate(disparities):
        if d is not None:
            costs[0, x, d] = 0
    return costs


def best_by_trying(costs, occlusion):
    """The least sum over all paths, by plain recursion over (column, disparity)."""
    width, num = costs.shape

    def paired(x, d):
        if x == 0:
            return int(costs[0, d])
        return int(costs[x, d]) + min(ending(x - 1, e) + (e - d) * occlusion for e in range(d, num))

    def ending(x, d):
        found = paired(x, d)
        if x > 0 and d > 0:
            found = min(found, ending(x - 1, d - 1) + occlusion)
        return found

    return min(ending(width - 1, d) for d in range(num))


def cost_of_path(costs, path, occlusion):
    """The sum of a path with NaN at pixels without a partner."""
    total, before = int(costs[0, int(path[0])]), int(path[0])
    for x in range(1, len(path)):
        if np.isnan(path[x]):
            total, before = total + occlusion, before + 1
            continue
        d = int(path[x])
        assert d <= before  # the order never reverses
        total, before = total + int(costs[x, d]) + (before - d) * occlusion, d
    return total


def test_a_nearer_object_hides_as_many_pixels_as_its_disparity_is_greater():
    path = [2] * 6 + [None] * 3 + [5] * 6 + [1] * 4
    found = match(costs_of(path, 8), occlusion=20)[0]
    expected = [np.nan if d is None else d for d in path]
    assert np.array_equal(found, np.array(expected, np.float32), equal_nan=True)


def test_what_stands_in_the_other_order_cannot_be_matched():
    # A thin near pole before a far wall: in the right image it stands left of what is left of it.
    path = [1] * 8 + [6] * 2 + [1] * 8
    found = match(costs_of(path, 8), occlusion=60)[0]
    assert not np.any(found[8:10] == 6)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_no_path_is_better(seed, occlusion):
    costs = np.random.default_rng(seed).integers(0, 60, (1, 5, 4), dtype=np.uint8)
    found = match(costs, occlusion)[0]
    assert cost_of_path(costs[0], found, occlusion) == best_by_trying(costs[0], occlusion)
