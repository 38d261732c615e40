"""Values by stamp: late, doubled and out of order."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from multi_localizer.stamped_values import Arrival, StampedValues

S = 1_000_000_000


def filled(*stamps: int) -> StampedValues[int]:
    values: StampedValues[int] = StampedValues(keep_ns=5 * S)
    for stamp in stamps:
        values.add(stamp, stamp)
    return values


def test_the_nearest_is_found_and_of_two_the_older() -> None:
    values = filled(10, 20, 40)
    assert values.nearest(21) == (20, 20)
    assert values.nearest(30) == (20, 20)
    assert values.nearest(31) == (40, 40)
    assert values.nearest(-5) == (10, 10)
    assert filled().nearest(3) is None


def test_neighbors_of_a_stamp() -> None:
    values = filled(10, 20)
    assert values.around(15) == ((10, 10), (20, 20))
    assert values.around(20) == ((20, 20), (20, 20))
    assert values.around(25) == ((20, 20), None)
    assert values.around(5) == (None, (10, 10))


def test_what_comes_twice_counts_once_and_first() -> None:
    values = filled(10)
    assert values.add(10, 99) is Arrival.DOUBLED
    assert values.nearest(10) == (10, 10) and len(values) == 1


def test_what_comes_late_takes_its_place() -> None:
    values = filled(10, 30)
    assert values.add(20, 20) is Arrival.LATE
    assert values.newest_ns == 30 and values.nearest(19) == (20, 20)


def test_what_is_too_late_is_refused_until_the_clock_must_have_been_set_back() -> None:
    values = filled(100 * S)
    said = [values.add(k, k) for k in range(1, 11)]
    assert said == [Arrival.TOO_LATE] * 9 + [Arrival.ANEW]
    assert values.newest_ns == 10 and len(values) == 1


def test_a_clock_set_back_by_less_than_is_kept_begins_anew_as_well() -> None:
    values = filled(*(k * S // 10 for k in range(100)))
    said = [values.add(8 * S + 50 + k * S // 10, k) for k in range(12)]
    assert said == [Arrival.LATE] * 9 + [Arrival.ANEW] + [Arrival.NEW] * 2
    assert len(values) == 3


@given(st.permutations(range(10)))
def test_order_of_arrival_does_not_matter(order) -> None:
    values = filled(*(k * S // 3 for k in order))
    assert values.newest_ns == 9 * S // 3
    for k in range(10):
        assert values.nearest(k * S // 3) == (k * S // 3, k * S // 3)


def test_only_some_seconds_are_kept() -> None:
    values = filled(0, 2 * S, 8 * S)
    assert len(values) == 1 and values.nearest(0) == (8 * S, 8 * S)
