"""When a robot was safe while something was wrong."""

from __future__ import annotations

import pytest

from experiments.faults_judge import (
    ASKED_MS,
    BASE,
    BRAKE,
    DIP,
    DRIVE,
    HALT,
    OTHER,
    STAND,
    DriveRecord,
    Moved,
    judge,
)

S, MS = 1_000_000_000, 1_000_000
DECEL = 0.6
STRUCK, END = 10 * S, 14 * S


def drive(stop_ns: int, *, brakes: float = 0.8, again_ns: int = 99 * S) -> DriveRecord:
    """Return a drive at 0.6 m/s whose commands are zero from a time on; the base then brakes."""
    record = DriveRecord()
    speed = 0.6
    for ns in range(9 * S, 15 * S, 10 * MS):
        is_told = ns < stop_ns or ns >= again_ns
        if ns % (50 * MS) == 0:
            record.commands.append(Moved(ns, 0.6 if is_told else 0.0, 0.0))
        speed = min(0.6, speed + 0.01) if is_told else max(0.0, speed - brakes * 0.01)
        if ns % (20 * MS) == 0:
            record.motion.append(Moved(ns, speed, 0.0))
    return record


def silent_from(ns: int, *, brakes_at: int) -> DriveRecord:
    record = drive(brakes_at)
    record.commands = [m for m in record.commands if m.ns < ns]
    return record


def test_a_zero_within_a_period_and_50_ms_is_a_halt() -> None:
    verdict = judge(drive(STRUCK + 50 * MS), HALT, STRUCK, STRUCK, END, DECEL)
    assert verdict.is_safe and verdict.stop_ms == pytest.approx(50.0)
    assert verdict.stand_s == pytest.approx(0.05 + 0.6 / 0.8, abs=0.05)


def test_a_zero_that_comes_later_is_none() -> None:
    verdict = judge(drive(STRUCK + 150 * MS), HALT, STRUCK, STRUCK, END, DECEL)
    assert not verdict.is_safe and verdict.stop_ms == pytest.approx(150.0)
    assert f"asked {ASKED_MS:.0f}" in verdict.seen


def test_the_time_counts_from_when_a_limit_is_over() -> None:
    due = STRUCK + 500 * MS
    verdict = judge(drive(due + 50 * MS), HALT, STRUCK, due, END, DECEL)
    assert verdict.is_safe and verdict.stop_ms == pytest.approx(50.0)


def test_a_zero_before_the_limit_takes_no_time() -> None:
    due = STRUCK + 500 * MS
    assert judge(drive(STRUCK + 300 * MS), HALT, STRUCK, due, END, DECEL).stop_ms == 0.0


def test_who_moves_on_before_the_fault_ends_did_not_halt() -> None:
    record = drive(STRUCK, again_ns=STRUCK + 2 * S)
    assert not judge(record, HALT, STRUCK, STRUCK, END, DECEL).is_safe
    assert judge(record, DIP, STRUCK, STRUCK, END, DECEL).is_safe


def test_a_command_just_before_the_zero_in_the_same_instant_is_no_moving_on() -> None:
    record = drive(STRUCK)
    first = next(k for k, m in enumerate(record.commands) if m.is_zero)
    record.commands.insert(first, Moved(record.commands[first].ns, 0.6, 0.0))
    assert judge(record, HALT, STRUCK, STRUCK, END, DECEL).is_safe


def test_a_base_that_rolls_on_after_the_zero_is_not_safe() -> None:
    verdict = judge(drive(STRUCK, brakes=0.0), HALT, STRUCK, STRUCK, END, DECEL)
    assert not verdict.is_safe and "truly stand" in verdict.seen


@pytest.mark.parametrize("expected", [HALT, DIP, BRAKE, BASE])
def test_a_drive_that_goes_on_is_no_stop(expected: str) -> None:
    verdict = judge(drive(99 * S), expected, STRUCK, STRUCK, END, DECEL)
    assert not verdict.is_safe and verdict.stop_ms is None


@pytest.mark.parametrize("expected", [HALT, DIP, BRAKE, BASE, DRIVE, STAND, OTHER])
def test_a_touch_is_never_safe(expected: str) -> None:
    record = drive(STRUCK)
    record.touches = [STRUCK + S]
    assert not judge(record, expected, STRUCK, STRUCK, END, DECEL).is_safe


def test_braking_counts_from_the_first_command_that_brakes() -> None:
    record, speed = drive(99 * S), 0.6
    record.commands = []
    for ns in range(9 * S, END, 50 * MS):
        speed = max(0.0, speed - DECEL * 0.05) if ns >= STRUCK + 50 * MS else speed
        record.commands.append(Moved(ns, speed, 0.0))
    record.motion = [Moved(m.ns, m.speed, 0.0) for m in record.commands]
    verdict = judge(record, BRAKE, STRUCK, STRUCK, END, DECEL)
    assert verdict.is_safe and verdict.stop_ms == pytest.approx(50.0)


def test_slowing_down_at_leisure_is_no_braking() -> None:
    record, speed = drive(99 * S), 0.6
    record.commands = []
    for ns in range(9 * S, END, 50 * MS):
        speed = max(0.0, speed - 0.2 * DECEL * 0.05) if ns >= STRUCK else speed
        record.commands.append(Moved(ns, speed, 0.0))
    assert not judge(record, BRAKE, STRUCK, STRUCK, END, DECEL).is_safe


def test_the_base_that_hears_nothing_brakes_by_its_own_limit() -> None:
    due = STRUCK + 500 * MS
    verdict = judge(silent_from(STRUCK, brakes_at=due), BASE, STRUCK, due, END, DECEL)
    assert verdict.is_safe and verdict.stop_ms <= 60.0
    late = silent_from(STRUCK, brakes_at=due + 300 * MS)
    assert not judge(late, BASE, STRUCK, due, END, DECEL).is_safe


def test_driving_on_is_to_get_somewhere() -> None:
    assert judge(drive(99 * S), DRIVE, STRUCK, STRUCK, END, DECEL).is_safe
    assert not judge(drive(STRUCK - 500 * MS), DRIVE, STRUCK, STRUCK, END, DECEL).is_safe
    assert judge(drive(STRUCK - 500 * MS), OTHER, STRUCK, STRUCK, END, DECEL).is_safe


def test_standing_is_not_to_move() -> None:
    assert judge(drive(9 * S), STAND, STRUCK, STRUCK, END, DECEL).is_safe
    assert not judge(drive(99 * S), STAND, STRUCK, STRUCK, END, DECEL).is_safe
