"""When a decision is due beside scans of some rate, with jitter and gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjmc_planner.control_pace import ControlPace

MS = 1_000_000
PERIOD_MS = 50


def decisions(scans_ms: list[float], end_ms: float) -> list[float]:
    """Return when is decided, as the node does it: by scans, and by a timer that begins anew."""
    pace = ControlPace(PERIOD_MS / 1e3)
    found: list[float] = []
    timer, scans = 0.0, [*sorted(scans_ms), float("inf")]
    while min(timer, scans[0]) < end_ms:
        is_scan = scans[0] <= timer
        now = scans.pop(0) if is_scan else timer
        wait = 0 if is_scan else pace.wait_ns(round(now * MS)) / MS
        if is_scan and not pace.is_due_at_scan(round(now * MS)):
            continue
        if wait:
            timer = now + wait
            continue
        pace.decided(round(now * MS))
        found.append(now)
        timer = now + PERIOD_MS
    return found


def waits(scans_ms: list[float], decided_ms: list[float]) -> np.ndarray:
    after = np.searchsorted(decided_ms, scans_ms)
    return np.array([decided_ms[k] - s for k, s in zip(after, scans_ms, strict=True)
                     if k < len(decided_ms)])  # fmt: skip


@pytest.mark.parametrize(
    ("between_ms", "longest_ms"), [(100.0, 1.0), (50.0, 1.0), (66.7, 1.0), (25.0, 26.0)]
)
def test_a_scan_waits_for_nothing_where_scans_are_no_more_often_than_decisions(
    between_ms: float, longest_ms: float
) -> None:
    rng = np.random.default_rng(1)
    scans = (7.0 + between_ms * np.arange(200) + rng.uniform(-0.4, 0.4, 200)).tolist()
    found = decisions(scans, scans[-1] + 200.0)
    assert np.percentile(waits(scans[10:], found), 99) <= longest_ms


def test_without_scans_it_decides_once_a_period() -> None:
    assert decisions([], 500.0) == [50.0 * k for k in range(10)]


def test_after_the_last_scan_it_goes_on_once_a_period() -> None:
    found = np.diff(decisions([100.0 * k for k in range(10)], 3000.0))
    assert found[-20:] == pytest.approx(np.full(20, 50.0))


@settings(max_examples=50)
@given(st.lists(st.floats(0.0, 3000.0), max_size=200))
def test_two_decisions_are_a_period_apart_up_to_a_share(scans_ms: list[float]) -> None:
    apart = np.diff(decisions(scans_ms, 3000.0))
    assert apart.min() >= 0.6 * PERIOD_MS - 1e-3
    assert apart.max() <= 1.4 * PERIOD_MS + 1e-3


def test_a_restart_forgets_what_time_it_was() -> None:
    pace = ControlPace(0.05)
    pace.is_due_at_scan(10**12)
    pace.decided(10**12)
    pace.restart()
    assert pace.is_due_at_scan(5)
    assert pace.wait_ns(6) == 0
