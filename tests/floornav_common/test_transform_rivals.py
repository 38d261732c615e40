"""Two sources of one transform told from one that corrects itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from floornav_common.transform_rivals import APART, WINDOW_NS, BackAndForth

PERIOD_NS = 50_000_000
HERE, BESIDE = SE2(1.0, 2.0, 0.5), SE2(1.0, 3.5, 0.5)


def told(*samples: tuple[int, SE2]) -> BackAndForth:
    found = BackAndForth()
    for stamp_ns, pose in samples:
        found.take(stamp_ns, pose)
    return found


def stream(pose: SE2, num: int, first_ns: int) -> list[tuple[int, SE2]]:
    return [(first_ns + k * PERIOD_NS, pose) for k in range(num)]


def test_two_that_take_turns_are_as_far_apart_as_they_say() -> None:
    both = stream(HERE, 20, 0) + stream(BESIDE, 20, PERIOD_NS // 3)
    assert told(*both).width() == pytest.approx(1.5)


def test_one_that_falls_silent_at_once_is_told_by_what_it_stamped_ahead() -> None:
    """As `grid_mapper`: its last samples are stamped 0.1 s after the other's first ones."""
    ours = stream(HERE, 40, 0)
    last_ns = ours[-1][0]
    other = stream(BESIDE, 2, last_ns - 2 * PERIOD_NS + 1)
    assert told(*ours, *other[:1]).width() == 0.0
    assert told(*ours, *other).width() == pytest.approx(1.5)


def test_a_loop_that_is_closed_is_one_jump_and_says_nothing() -> None:
    both = stream(HERE, 20, 0) + stream(BESIDE, 20, 20 * PERIOD_NS)
    assert told(*both).width() == 0.0


def test_one_bad_estimate_says_nothing_but_a_second_does() -> None:
    poses = [HERE] * 5 + [BESIDE] + [HERE] * 5 + [BESIDE] + [HERE] * 5
    samples = [(k * PERIOD_NS, pose) for k, pose in enumerate(poses)]
    assert told(*samples[:11]).width() == 0.0
    assert told(*samples).width() == pytest.approx(1.5)


def test_being_told_three_other_places_in_a_row_is_no_return() -> None:
    poses = [HERE] * 5 + [SE2(5.0, 0.0, 0.0)] * 5 + [SE2(0.0, 9.0, 2.0)] * 5 + [BESIDE] * 5
    assert told(*[(k * PERIOD_NS, pose) for k, pose in enumerate(poses)]).width() == 0.0


def test_a_robot_that_drives_fast_with_slow_odometry_is_one_source() -> None:
    """2 m/s at 4 Hz: each sample is 0.5 m from the last, and none comes back."""
    samples = [(k * 250_000_000, SE2(0.5 * k, 0.0, 0.0)) for k in range(20)]
    assert told(*samples).width() == 0.0


def test_noise_below_the_limit_is_one_source() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform(-0.3 * APART, 0.3 * APART, (40, 3))
    assert told(*[(k * PERIOD_NS, SE2(*row)) for k, row in enumerate(places)]).width() == 0.0


def test_two_that_differ_in_yaw_alone_are_told_across_the_wrap() -> None:
    near, far = SE2(0.0, 0.0, math.pi - 0.05), SE2(0.0, 0.0, -math.pi + 0.05)
    assert told(*stream(near, 9, 0), *stream(far, 9, 7)).width() == 0.0
    far = SE2(0.0, 0.0, -math.pi + 0.45)
    assert told(*stream(near, 9, 0), *stream(far, 9, 7)).width() == pytest.approx(0.5)


def test_a_small_turn_counts_by_what_it_moves_where_the_robot_is() -> None:
    both = told(*stream(SE2(0.0, 0.0, 0.0), 9, 0), *stream(SE2(0.0, 0.0, 0.02), 9, 7))
    assert both.width() == 0.0
    assert both.width((50.0, 0.0)) == pytest.approx(1.0, abs=1e-3)


def test_what_is_over_is_forgotten() -> None:
    both = told(*stream(HERE, 20, 0), *stream(BESIDE, 20, 7))
    last_ns = 19 * PERIOD_NS
    for stamp_ns, pose in stream(BESIDE, 2 + WINDOW_NS // PERIOD_NS, last_ns + PERIOD_NS):
        is_all_there = stamp_ns <= last_ns + WINDOW_NS // 2
        both.take(stamp_ns, pose)
        assert both.width() > 0.0 or not is_all_there
    assert both.width() == 0.0


def test_nothing_is_left_after_a_restart() -> None:
    both = told(*stream(HERE, 20, 0), *stream(BESIDE, 20, 7))
    both.clear()
    assert both.width() == 0.0


@settings(max_examples=60)
@given(
    jump_at=st.integers(0, 30),
    is_two=st.booleans(),
    order=st.permutations(range(30)),
    shift=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_neither_the_order_of_arrival_nor_where_the_map_begins_matters(
    jump_at: int, is_two: bool, order: list[int], shift: tuple[float, float, float]
) -> None:
    """One jump anywhere is never told as two sources; two sources always are."""
    poses = [BESIDE if (k % 2 if is_two else k >= jump_at) else HERE for k in range(30)]
    T_other_map = SE2(*shift)
    found = told(*[(k * PERIOD_NS, T_other_map @ poses[k]) for k in order])
    assert found.width() == pytest.approx(1.5 if is_two else 0.0)
