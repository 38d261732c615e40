"""Sonar readings that wait for the scans round their stamps, so many of each sonar."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field

from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2

MAX_WAITING = 500
"""Readings of one sonar that may wait: ten seconds at 50 Hz."""


@dataclass(order=True)
class WaitingReading:
    """A reading whose pose is not known yet; sorts by stamp, then as it came."""

    stamp_ns: int
    number: int
    reading: RangeReading = field(compare=False)
    T_base_sonar: SE2 = field(compare=False)
    sensor: str = field(compare=False)


class WaitingReadings:
    """Gives readings back in the order of their stamps; no sonar takes another's room."""

    def __init__(self) -> None:
        self._by_sensor: dict[str, list[WaitingReading]] = {}
        self._num_taken = 0

    def __len__(self) -> int:
        return sum(len(waiting) for waiting in self._by_sensor.values())

    def push(self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str) -> bool:
        """Take a reading; return whether there was room, else that sensor's oldest is dropped."""
        self._num_taken += 1
        waiting = self._by_sensor.setdefault(sensor, [])
        entry = WaitingReading(stamp_ns, self._num_taken, reading, T_base_sonar, sensor)
        heapq.heappush(waiting, entry)
        if len(waiting) <= MAX_WAITING:
            return True
        heapq.heappop(waiting)
        return False

    def pop_until(self, stamp_ns: int) -> Iterator[WaitingReading]:
        """Yield and drop, oldest first, the readings up to a stamp."""
        while heads := [w for w in self._by_sensor.values() if w and w[0].stamp_ns <= stamp_ns]:
            yield heapq.heappop(min(heads, key=lambda waiting: waiting[0]))

    def clear(self) -> int:
        """Drop all; return how many."""
        num = len(self)
        self._by_sensor.clear()
        return num
