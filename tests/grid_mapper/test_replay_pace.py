"""The pace of a replay on hand-made clocks."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grid_mapper.recordings.playback import PlayWindow
from grid_mapper.recordings.replay_pace import ReplayPace, Stopped

S = 1_000_000_000
START_NS, BEGAN_S = 5_000 * S, 40.0
TOL_S = 1e-6


class HandMadeClock:
    """Goes on only while somebody sleeps, and each sleep takes longer by `late_s`."""

    def __init__(self, late_s: float = 0.0) -> None:
        self.now, self._late_s = BEGAN_S, late_s

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds + self._late_s


def pace_of(clock: HandMadeClock, rate: float = 1.0, clock_hz: float = 10.0) -> ReplayPace:
    window = PlayWindow(START_NS, START_NS + 100 * S)
    return ReplayPace(window, rate, clock_hz, BEGAN_S, lambda: clock.now, clock.sleep)


def wait(pace: ReplayPace, after_s: float) -> list[float]:
    """Wait for what was recorded so long after the start; return the ticks, after the start."""
    ticks: list[int] = []
    pace.wait_for(START_NS + round(after_s * S), ticks.append, lambda: False)
    return [(tick_ns - START_NS) / S for tick_ns in ticks]


@pytest.mark.parametrize(("rate", "lasts_s"), [(1.0, 3.0), (2.0, 1.5), (0.25, 12.0)])
def test_a_message_is_let_go_when_it_is_due_at_the_rate(rate: float, lasts_s: float) -> None:
    clock = HandMadeClock()
    wait(pace_of(clock, rate), 3.0)
    assert clock.now == pytest.approx(BEGAN_S + lasts_s, abs=TOL_S)


def test_time_is_told_at_its_rate_in_real_time_and_in_recorded_time() -> None:
    told = wait(pace_of(HandMadeClock(), rate=2.0, clock_hz=10.0), 0.95)
    assert told == pytest.approx([0.2, 0.4, 0.6, 0.8], abs=TOL_S)


def test_without_a_clock_rate_waiting_still_asks_whether_to_stop() -> None:
    asked = 0

    def should_stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 3

    with pytest.raises(Stopped):
        pace_of(HandMadeClock(), clock_hz=0.0).wait_for(
            START_NS + 100 * S, lambda _: None, should_stop
        )
    assert asked == 4


def test_what_is_overdue_goes_at_once_and_lateness_does_not_add_up() -> None:
    clock = HandMadeClock(late_s=0.35)
    pace = pace_of(clock)
    wait(pace, 0.1)
    late = clock.now
    assert wait(pace, 0.2) == [] and clock.now == late
    for step in range(1, 50):
        wait(pace, 1.0 * step)
        assert clock.now - BEGAN_S - step < 0.35 + TOL_S


@given(
    st.floats(0.1, 20.0),
    st.just(0.0) | st.floats(0.1, 200.0),
    st.floats(0.0, 0.5),
    st.lists(st.floats(0.0, 3.0), min_size=1, max_size=8),
)
def test_nothing_is_let_go_or_told_before_it_is_due(
    rate: float, clock_hz: float, late_s: float, offsets: list[float]
) -> None:
    clock = HandMadeClock(late_s)
    pace = pace_of(clock, rate, clock_hz)
    told = [0.0]
    for after_s in sorted(offsets):
        new = wait(pace, after_s)
        assert all(tick <= after_s + TOL_S for tick in new)
        told += new
        assert clock.now >= BEGAN_S + after_s / rate - TOL_S
        assert told[-1] <= (clock.now - BEGAN_S) * rate + TOL_S
    assert told == sorted(told)
