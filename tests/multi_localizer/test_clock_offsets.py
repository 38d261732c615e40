"""Clocks of teammates: offsets from notes that go round, and what one-way stamps tell."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from multi_localizer.clock_offsets import ClockOffset, TeammateClock, clock_problem

MS = 1_000_000
S = 1_000_000_000


def exchange(
    ours: TeammateClock, theirs: TeammateClock, at_ns: int, offset_ns: int, there: int, back: int
) -> None:
    """Send one note there and, 200 ms later, one back; `at_ns` is our clock."""
    theirs.take_note(at_ns, ours.echo_ns(at_ns), at_ns + there + offset_ns)
    sent_ns = at_ns + there + 200 * MS
    echo_ns = theirs.echo_ns(sent_ns + offset_ns)
    ours.take_note(sent_ns + offset_ns, echo_ns, sent_ns + back)


def test_a_clock_half_a_second_ahead_over_a_line_of_ten_milliseconds() -> None:
    ours, theirs = TeammateClock(), TeammateClock()
    exchange(ours, theirs, 100 * S, 500 * MS, 10 * MS, 10 * MS)
    assert ours.offset == ClockOffset(500 * MS, 10 * MS + 1)
    exchange(ours, theirs, 101 * S, 500 * MS, 10 * MS, 10 * MS)
    assert theirs.offset == ClockOffset(-500 * MS, 10 * MS + 1)


@example(offset_ms=0, ways_ms=[*((0, k) for k in range(16)), (0, 0), (0, 16), (0, 17)])
@given(
    offset_ms=st.integers(-100_000, 100_000),
    ways_ms=st.lists(st.tuples(st.integers(0, 900), st.integers(0, 900)), min_size=1, max_size=20),
)
def test_the_true_offset_always_lies_within_the_error(offset_ms, ways_ms) -> None:
    ours, theirs = TeammateClock(), TeammateClock()
    for k, (there, back) in enumerate(ways_ms):
        exchange(ours, theirs, (1000 + 3 * k) * S, offset_ms * MS, there * MS, back * MS)
    found = ours.offset
    assert found is not None and found.error_ns is not None
    assert abs(found.offset_ns - offset_ms * MS) <= found.error_ns
    assert found.error_ns <= min(there + back for there, back in ways_ms[-16:]) * MS // 2 + 1


def test_doubled_and_late_notes_change_nothing() -> None:
    rng = np.random.default_rng(0)
    ours, theirs = TeammateClock(), TeammateClock()
    for k in range(5):
        there, back = rng.integers(1, 30, 2)
        exchange(ours, theirs, (50 + k) * S, 40 * MS, int(there) * MS, int(back) * MS)
    before = ours.offset
    echo = ours.echo_ns(60 * S)
    ours.take_note(51 * S + 40 * MS, 51 * S, 60 * S)  # eight seconds late
    assert ours.offset == before and ours.echo_ns(60 * S) == echo


def test_a_clock_that_was_set_is_believed_at_once() -> None:
    ours, theirs = TeammateClock(), TeammateClock()
    exchange(ours, theirs, 100 * S, 3 * S, 1 * MS, 1 * MS)
    exchange(ours, theirs, 101 * S, 0, 20 * MS, 20 * MS)
    assert ours.offset is not None and abs(ours.offset.offset_ns) <= 20 * MS


def test_one_way_stamps_tell_the_least_offset() -> None:
    clock = TeammateClock()
    assert clock.offset is None
    for delay_ms in (80, 5, 300):
        clock.take_stamp(100 * S + 2 * S, 100 * S + delay_ms * MS)
    assert clock.offset == ClockOffset(2 * S - 5 * MS, None)


def test_a_note_without_echo_gives_an_answer_but_no_offset() -> None:
    clock = TeammateClock()
    clock.take_note(7 * S, None, 9 * S)
    assert clock.offset is None
    assert clock.echo_ns(10 * S) == 8 * S
    clock.restart()
    assert clock.echo_ns(10 * S) is None


def test_words_say_which_side_and_how_surely() -> None:
    allowed = 100 * MS
    assert clock_problem(None, allowed) == ""
    assert clock_problem(ClockOffset(105 * MS, 10 * MS), allowed) == ""
    ahead = clock_problem(ClockOffset(2 * S, 10 * MS), allowed)
    assert ahead == "its clock is 2.000 s ahead (within 0.010 s)"
    assert "behind" in clock_problem(ClockOffset(-2 * S, 10 * MS), allowed)
    assert clock_problem(ClockOffset(2 * S, None), allowed) == "its clock is at least 2.000 s ahead"
    assert "late, or its clock" in clock_problem(ClockOffset(-2 * S, None), allowed)
    assert clock_problem(ClockOffset(-50 * MS, None), allowed) == ""


def test_simulated_time_that_was_not_told_yet_says_nothing() -> None:
    clock = TeammateClock()
    clock.take_stamp(100 * S, 0)
    clock.take_stamp(0, 100 * S)
    clock.take_note(100 * S, 0, 0)
    assert clock.offset is None and clock.echo_ns(S) is None
