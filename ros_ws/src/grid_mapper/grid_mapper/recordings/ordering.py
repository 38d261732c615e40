"""Defined behaviour for stamps that go back: counted always, a jump only when they go far."""

from __future__ import annotations

from dataclasses import dataclass

from grid_mapper.recordings.events import Counts

JUMP_NS = 2_000_000_000


@dataclass
class StampWatch:
    """Compares each scan's stamp with the one recorded before it.

    Small steps back (late delivery, clocks being adjusted) leave the order as it is recorded.
    A step back of more than 2 s is a jump: the recording starts again, as a looped bag does.
    """

    counts: Counts
    last_ns: int | None = None

    def is_jump(self, stamp_ns: int) -> bool:
        """Count the stamp; return True if time jumped back with it."""
        last_ns, self.last_ns = self.last_ns, stamp_ns
        self.counts.scans += 1
        if last_ns is None or stamp_ns > last_ns:
            return False
        if stamp_ns == last_ns:
            self.counts.stamps_repeated += 1
            return False
        self.counts.stamps_backwards += 1
        if last_ns - stamp_ns > JUMP_NS:
            self.counts.jumps += 1
            return True
        return False


def seconds_to_ns(text: str) -> int:
    """Return a decimal number of seconds as ns, without rounding through a float."""
    whole, _, fraction = text.partition(".")
    if not (whole.lstrip("-").isdigit() and (not fraction or fraction.isdigit())):
        return round(float(text) * 1e9)
    sign = -1 if whole.startswith("-") else 1
    return int(whole) * 1_000_000_000 + sign * int(fraction[:9].ljust(9, "0") or 0)
