import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multi_localizer.stereo_cost import MAX_COST
from multi_localizer.stereo_paths import MAX_PRICE, from_above, from_both_sides, jump_prices


def step(cost, before, small, price):
    """One step of the DP in plain integers, without the least of the pixel before."""
    least = min(before)
    return [
        int(c)
        + min(
            min(before[e] + small * abs(e - d) for e in range(len(before)) if abs(e - d) <= 1),
            least + price,
        )
        - least
        for d, c in enumerate(cost)
    ]


def along(costs, gray, small, prices):
    """Sums of the path along a row, by plain integers."""
    found = [[int(c) for c in costs[0]]]
    for x in range(1, len(costs)):
        price = int(prices[abs(int(gray[x]) - int(gray[x - 1]))])
        found.append(step(costs[x], found[-1], small, price))
    return np.array(found)


def row(seed, width=7, num=5, most=MAX_COST):
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, most + 1, (width, num), dtype=np.uint8)
    return costs, rng.integers(0, 256, width, dtype=np.uint8)


settings_of_prices = st.tuples(st.integers(0, MAX_PRICE), st.integers(1, MAX_PRICE)).map(sorted)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), settings_of_prices)
def test_paths_from_both_sides_are_those_of_plain_integers(seed, sizes):
    small, large = sizes[0], max(sizes[1], 1)
    costs, gray = row(seed)
    prices = jump_prices(large, small, 30.0)
    memory = np.full((2, 8, 7), 255, dtype=np.uint8)
    sums = np.zeros(costs.shape, dtype=np.uint16)
    from_both_sides(costs, gray, np.uint8(small), prices, memory[0], memory[1], sums)
    right = along(costs, gray, small, prices)
    left = along(costs[::-1], gray[::-1], small, prices)[::-1]
    assert np.array_equal(sums, right + left)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), settings_of_prices)
def test_paths_from_above_are_those_of_plain_integers(seed, sizes):
    small, large = sizes[0], max(sizes[1], 1)
    prices = jump_prices(large, small, 30.0)
    rows = [row(seed + k) for k in range(4)]
    above, here = np.zeros((2, 7, 8), dtype=np.uint8)
    for memory in (above, here):
        memory[:, 0] = memory[:, 6] = 255
    for y, (costs, gray) in enumerate(rows):
        sums = np.zeros(costs.shape, dtype=np.uint16)
        before = rows[max(y - 1, 0)][1]
        from_above(costs, gray, before, np.uint8(small), prices, above, here, sums)
        above, here = here, above
    for x in range(7):
        column = np.array([costs[x] for costs, _ in rows])
        grays = np.array([gray[x] for _, gray in rows])
        assert sums[x].tolist() == along(column, grays, small, prices)[-1].tolist()


def test_a_jump_costs_half_where_the_gray_changes_by_the_scale():
    prices = jump_prices(120, 50, 30.0)
    assert prices[0] == 120 and prices[30] == 60
    assert prices[255] == 51  # never less than a change by 1
    assert jump_prices(50, 50, 30.0).tolist() == [50] * 256
