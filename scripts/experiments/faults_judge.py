"""Whether a robot was safe while something was wrong: from what it did, not from what nodes say."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from dataclasses import dataclass, field

HALT, BRAKE, BASE, DIP, DRIVE, STAND, OTHER = (
    "halt", "brake", "base", "dip", "drive", "stand", "other"
)  # fmt: skip
"""What is expected: a command of zero, and to stand; braking at the limit to zero; the base stops
by itself for silence; zero at first; driving on; standing where it stands; what a check sees."""

ASKED_MS = 100.0
"""One control period of 50 ms and 50 ms more."""
_STILL, _TURN_STILL = 0.02, 0.04  # of the true motion: wheels and physics shake a little
_SLOWER = 0.03  # m/s: by so much slower, the base brakes
_SHARE_OF_LIMIT = 0.8  # of the braking limit: odd steps at the clock's beats
_ROLL_OUT_S = 0.6
_ON_ITS_WAY_M = 0.5


@dataclass(frozen=True)
class Moved:
    """A moment of motion, commanded or true.

    Attributes:
        ns: Simulator's time.
        speed: m/s.
        yaw_rate: rad/s.
    """

    ns: int
    speed: float
    yaw_rate: float

    @property
    def is_zero(self) -> bool:
        """Whether it is a command to stand."""
        return self.speed == 0.0 and self.yaw_rate == 0.0


@dataclass
class DriveRecord:
    """What a drive left.

    Attributes:
        commands: As they arrived at the simulator.
        motion: True.
        touches: Times at which a touch began.
    """

    commands: list[Moved] = field(default_factory=list)
    motion: list[Moved] = field(default_factory=list)
    touches: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Verdict:
    """How one fault went.

    Attributes:
        is_safe: Whether nothing was touched and the robot did what was expected.
        stop_ms: From when it had to stop until it did; None where it need not.
        stand_s: From when it had to stop until it truly stood; None where it did not.
        seen: In words.
    """

    is_safe: bool
    stop_ms: float | None
    stand_s: float | None
    seen: str


def between(moments: list[Moved], from_ns: int, to_ns: int) -> list[Moved]:
    """Return the moments from one time up to another, both counted in."""
    first = bisect_left(moments, from_ns, key=lambda m: m.ns)
    return list(itertools.takewhile(lambda m: m.ns <= to_ns, moments[first:]))


def judge(
    record: DriveRecord, expected: str, struck_ns: int, due_ns: int, end_ns: int, decel: float
) -> Verdict:
    """Return whether a robot was safe.

    Args:
        record: Of the drive.
        expected: `HALT`, `BRAKE`, `BASE`, `DIP`, `DRIVE`, `STAND` or `OTHER`.
        struck_ns: When the fault began.
        due_ns: From when on the robot had to stop: where a time limit is on silence, its end.
        end_ns: When the fault ended.
        decel: How hard it may brake, m/s^2.
    """
    if any(struck_ns <= ns <= end_ns for ns in record.touches):
        return Verdict(False, None, None, "the robot touched something")
    if expected in (DRIVE, STAND, OTHER):
        return _judge_no_stop(record, expected, struck_ns, end_ns)
    find = {HALT: _first_zero, DIP: _first_zero, BRAKE: _first_brake, BASE: _first_slower}[expected]
    stop_ns = find(record, struck_ns, due_ns, end_ns, decel)
    if stop_ns is None:
        return Verdict(False, None, None, "did not stop while the fault was there")
    stop_ms = max(0.0, (stop_ns - due_ns) * 1e-6)
    stand_ns = _standing(record, stop_ns, end_ns)
    stand_s = None if stand_ns is None else max(0.0, (stand_ns - due_ns) * 1e-9)
    why = _why_unsafe(record, expected, stop_ns, end_ns, stop_ms, decel)
    how = {BRAKE: "braking", BASE: "the base brakes"}.get(expected, "zero")
    total = (stop_ns - struck_ns) * 1e-9
    return Verdict(not why, stop_ms, stand_s, why or f"{how} {total:.2f} s after it began")


def _judge_no_stop(record: DriveRecord, expected: str, struck_ns: int, end_ns: int) -> Verdict:
    motion = between(record.motion, struck_ns, end_ns)
    far = _way(motion)
    if expected == STAND:
        is_still = all(map(_is_still, motion))
        return Verdict(is_still, None, None, "stood" if is_still else "moved")
    least = min((m.speed for m in motion), default=0.0)
    is_on_its_way = expected == OTHER or least > _STILL or far > _ON_ITS_WAY_M
    text = f"drove {far:.1f} m, touched nothing" if far > 0.0 else "touched nothing"
    return Verdict(is_on_its_way, None, None, text if is_on_its_way else f"drove {far:.1f} m only")


def _why_unsafe(
    record: DriveRecord, expected: str, stop_ns: int, end_ns: int, stop_ms: float, decel: float
) -> str:
    """Return why a stop was none; "" if it was."""
    if stop_ms > ASKED_MS:
        return f"stopped after {stop_ms:.0f} ms, asked {ASKED_MS:.0f}"
    if expected == DIP:
        return ""
    # Commands of one instant come in their order: the zero may be behind another.
    since = between(record.commands, stop_ns, end_ns)
    later = itertools.dropwhile(lambda m: not m.is_zero, since)
    if expected == HALT and not all(m.is_zero for m in later):
        return "moved on before the fault ended"
    at_stop = between(record.motion, stop_ns, end_ns)
    roll_out_ns = round(((at_stop[0].speed if at_stop else 0.0) / decel + _ROLL_OUT_S) * 1e9)
    after = between(record.motion, stop_ns + roll_out_ns, end_ns)
    if not after or not all(map(_is_still, after)):
        return "did not truly stand while the fault was there"
    return ""


def _first_zero(
    record: DriveRecord, struck_ns: int, due_ns: int, end_ns: int, decel: float
) -> int | None:
    zeros = (m.ns for m in between(record.commands, struck_ns, end_ns) if m.is_zero)
    return next(zeros, None)


def _first_brake(
    record: DriveRecord, struck_ns: int, due_ns: int, end_ns: int, decel: float
) -> int | None:
    """Return when commands begin to fall as fast as they may, and do so until they are zero."""
    commands = between(record.commands, struck_ns, end_ns)
    last = next((k for k, m in enumerate(commands) if m.speed == 0.0), None)
    if last is None:
        return None
    first = last
    while first > 0 and _is_braking(commands[first - 1], commands[first], decel):
        first -= 1
    braking = commands[first + 1 : last + 1]
    return braking[0].ns if braking else commands[last].ns


def _is_braking(before: Moved, after: Moved, decel: float) -> bool:
    dt = max(1e-9 * (after.ns - before.ns), 0.0)
    enough = min(_SHARE_OF_LIMIT * decel * dt, before.speed)
    return after.speed < before.speed and after.speed <= before.speed - 0.5 * enough


def _first_slower(
    record: DriveRecord, struck_ns: int, due_ns: int, end_ns: int, decel: float
) -> int | None:
    motion = between(record.motion, due_ns, end_ns)
    if not motion:
        return None
    speed = motion[0].speed
    return next((m.ns for m in motion if _is_still(m) or m.speed < speed - _SLOWER), None)


def _standing(record: DriveRecord, from_ns: int, end_ns: int) -> int | None:
    """Return from when on the robot truly stands until the fault ends."""
    since = None
    for moment in between(record.motion, from_ns, end_ns):
        since = (moment.ns if since is None else since) if _is_still(moment) else None
    return since


def _is_still(moment: Moved) -> bool:
    return moment.speed < _STILL and abs(moment.yaw_rate) < _TURN_STILL


def _way(motion: list[Moved]) -> float:
    pairs = itertools.pairwise(motion)
    return math.fsum(0.5e-9 * (a.speed + b.speed) * (b.ns - a.ns) for a, b in pairs)
