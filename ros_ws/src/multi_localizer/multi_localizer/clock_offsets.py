"""How far teammates' clocks are from ours, by notes that robots send each other round.

A note of a robot says to one teammate: "by my clock it is `stamp`; had your last note gone on
running with me, it would now read `echo`". When it comes at our time `now`, the way there and back
took `now - echo`, and their clock read `stamp` somewhere between `echo` and `now` of ours. With the
middle taken, the error is at most half the way (as NTP, RFC 5905, with the turn taken out).

Where nobody answers, stamps of other messages tell one side only: a stamp that lies ahead of our
clock shows that theirs is ahead; one that lies behind may as well have come late.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

_KEPT_NOTES = 16
_KEPT_STAMPS = 50
_SET_NS = 1_000_000


@dataclass(frozen=True)
class ClockOffset:
    """Their clock less ours.

    Attributes:
        offset_ns: What it is, or with one-way stamps the least it can be.
        error_ns: How far off at most; None where only one side is known.
    """

    offset_ns: int
    error_ns: int | None

    @property
    def is_two_way(self) -> bool:
        """Whether it is known from both sides."""
        return self.error_ns is not None


class TeammateClock:
    """The clock of one teammate as ours sees it.

    A clock that reads 0 is simulated time that has not been told yet: nothing is learned of it.
    """

    def __init__(self) -> None:
        """Start knowing nothing."""
        self._heard: tuple[int, int] | None = None  # their stamp, our time
        self._rounds: deque[tuple[int, int]] = deque(maxlen=_KEPT_NOTES)  # way, offset
        self._one_way: deque[int] = deque(maxlen=_KEPT_STAMPS)  # stamp - now

    def take_note(self, stamp_ns: int, echo_ns: int | None, now_ns: int) -> None:
        """Take a note of theirs to us.

        Args:
            stamp_ns: Their clock when they sent it.
            echo_ns: Our clock by their reckoning at that moment; None before they heard us.
            now_ns: Our clock as it came.
        """
        if stamp_ns <= 0 or now_ns <= 0:
            return
        if self._heard is None or stamp_ns > self._heard[0]:
            self._heard = stamp_ns, now_ns
        if echo_ns is None or now_ns < echo_ns:
            return
        way, offset = now_ns - echo_ns, stamp_ns - (echo_ns + now_ns) // 2
        if any(2 * abs(offset - o) > way + w + _SET_NS for w, o in self._rounds):
            self._rounds.clear()  # one of the clocks was set
        if (way, offset) in self._rounds:
            self._rounds.remove((way, offset))  # one that is doubled counts once, as the newest
        self._rounds.append((way, offset))

    def take_stamp(self, stamp_ns: int, now_ns: int) -> None:
        """Take the stamp of any other message of theirs, as it came."""
        if stamp_ns > 0 and now_ns > 0:
            self._one_way.append(stamp_ns - now_ns)

    def echo_ns(self, now_ns: int) -> int | None:
        """Return what to write to them: their last note's stamp, run on until now."""
        if self._heard is None:
            return None
        stamp_ns, heard_ns = self._heard
        return stamp_ns + now_ns - heard_ns

    @property
    def offset(self) -> ClockOffset | None:
        """What is known; None before anything came."""
        if self._rounds:
            way, offset = min(self._rounds)
            return ClockOffset(offset, way // 2 + 1)
        return ClockOffset(max(self._one_way), None) if self._one_way else None

    def restart(self) -> None:
        """Forget all: our own clock jumped."""
        self._heard = None
        self._rounds.clear()
        self._one_way.clear()


def clock_problem(offset: ClockOffset | None, allowed_ns: int) -> str:
    """Return what is wrong with a teammate's clock, in words; "" if nothing, or nothing is known.

    Args:
        offset: What is known of it.
        allowed_ns: How far off it may be.
    """
    if offset is None:
        return ""
    ns, error_ns = offset.offset_ns, offset.error_ns
    if error_ns is not None:
        if abs(ns) <= allowed_ns + error_ns:
            return ""
        side = "ahead" if ns > 0 else "behind"
        return f"its clock is {abs(ns) / 1e9:.3f} s {side} (within {error_ns / 1e9:.3f} s)"
    if ns > allowed_ns:
        return f"its clock is at least {ns / 1e9:.3f} s ahead"
    if ns < -allowed_ns:
        return f"its messages come {-ns / 1e9:.3f} s late, or its clock is behind"
    return ""
