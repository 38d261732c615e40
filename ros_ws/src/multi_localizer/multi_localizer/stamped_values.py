"""Values by stamp, a few seconds of them: found by the nearest stamp, whatever order they came in.

Messages between robots come late, twice or not at all. One that comes twice is told from two, one
that comes late takes its place among the others, and one too late for that is refused. When nothing
else comes any more, the sender's clock was set back, and all begins anew.
"""

from __future__ import annotations

from bisect import bisect_left
from enum import Enum
from typing import Generic, TypeVar

V = TypeVar("V")

KEEP_NS = 5_000_000_000
_LATE_IN_A_ROW = 10


class Arrival(Enum):
    """What became of a value."""

    NEW = "newest"
    LATE = "put in its place"
    DOUBLED = "doubled"
    TOO_LATE = "too late"
    ANEW = "begun anew"


class StampedValues(Generic[V]):
    """Values in stamp order.

    Args:
        keep_ns: How long behind the newest they are kept.
    """

    def __init__(self, keep_ns: int = KEEP_NS) -> None:
        """Start empty."""
        self._keep_ns = keep_ns
        self._stamps: list[int] = []
        self._values: list[V] = []
        self._num_late = 0

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._stamps)

    @property
    def newest_ns(self) -> int | None:
        """Newest stamp; None while empty."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp_ns: int, value: V) -> Arrival:
        """Put a value in its place; the first of one stamp counts."""
        at = bisect_left(self._stamps, stamp_ns)
        is_newest = at == len(self._stamps)
        if stamp_ns == self.newest_ns:
            return Arrival.DOUBLED
        self._num_late = 0 if is_newest else self._num_late + 1
        if self._num_late == _LATE_IN_A_ROW:
            self.clear()
            self._stamps, self._values = [stamp_ns], [value]
            return Arrival.ANEW
        if not is_newest and self._stamps[at] == stamp_ns:
            return Arrival.DOUBLED
        if not is_newest and stamp_ns < self._stamps[-1] - self._keep_ns:
            return Arrival.TOO_LATE
        self._stamps.insert(at, stamp_ns)
        self._values.insert(at, value)
        num_old = bisect_left(self._stamps, self._stamps[-1] - self._keep_ns)
        del self._stamps[:num_old], self._values[:num_old]
        return Arrival.NEW if is_newest else Arrival.LATE

    def nearest(self, stamp_ns: int) -> tuple[int, V] | None:
        """Return the stamp and value nearest to a stamp, the older of two; None while empty."""
        around = self.around(stamp_ns)
        known = [each for each in around if each is not None]
        return min(known, key=lambda each: abs(each[0] - stamp_ns)) if known else None

    def around(self, stamp_ns: int) -> tuple[tuple[int, V] | None, tuple[int, V] | None]:
        """Return the last at or before a stamp, and the first at or after it."""
        at = bisect_left(self._stamps, stamp_ns)
        after = (self._stamps[at], self._values[at]) if at < len(self._stamps) else None
        if after is not None and after[0] == stamp_ns:
            return after, after
        before = (self._stamps[at - 1], self._values[at - 1]) if at else None
        return before, after

    def clear(self) -> None:
        """Forget all."""
        self._stamps.clear()
        self._values.clear()
        self._num_late = 0
