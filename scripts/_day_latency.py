"""How long what a stamp names takes until its outcome is here, in real time.

The simulator's `/clock` says which real instant a simulated one was; between its messages the
instant is interpolated, so that a slow or a fast simulation makes no difference.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict, deque

import numpy as np

_KEPT = 1000  # clock messages: 20 s of simulated time


class StampClock:
    """Real time of simulated instants."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque(maxlen=_KEPT)
        self._walls: deque[float] = deque(maxlen=_KEPT)

    def tick(self, stamp_ns: int, wall_s: float) -> None:
        """Take a clock message; an older one than the last is left out."""
        if not self._stamps or stamp_ns > self._stamps[-1]:
            self._stamps.append(stamp_ns)
            self._walls.append(wall_s)

    @property
    def newest_ns(self) -> int:
        """The last instant heard of."""
        return self._stamps[-1] if self._stamps else 0

    def wall_of(self, stamp_ns: int) -> float | None:
        """Return when an instant was, s; None if that is not known (any more, or yet)."""
        k = bisect_left(self._stamps, stamp_ns)
        if k == len(self._stamps) or (k == 0 and self._stamps[0] != stamp_ns):
            return None
        after = self._walls[k]
        if self._stamps[k] == stamp_ns:
            return after
        share = (stamp_ns - self._stamps[k - 1]) / (self._stamps[k] - self._stamps[k - 1])
        return self._walls[k - 1] + share * (after - self._walls[k - 1])


class Latencies:
    """Counts and delays of messages by topic.

    Attributes:
        counts: Messages by topic.
        stamps: Their stamps by topic, those that have one.
    """

    def __init__(self, clock: StampClock) -> None:
        self.counts: dict[str, int] = defaultdict(int)
        self.stamps: dict[str, set[int]] = defaultdict(set)
        self._clock = clock
        self._late: dict[str, list[float]] = defaultdict(list)

    def note(self, topic: str, stamp_ns: int | None, wall_s: float) -> None:
        """Take a message that came at a real time, s; `stamp_ns` None: it has no stamp."""
        self.counts[topic] += 1
        if stamp_ns is None:
            return
        self.stamps[topic].add(stamp_ns)
        was = self._clock.wall_of(stamp_ns)
        if was is not None:
            self._late[topic].append(max(0.0, wall_s - was))

    def figures(self) -> dict[str, dict[str, float | int | None]]:
        """Return messages, median and 99th percentile (ms) by topic."""
        found: dict[str, dict[str, float | int | None]] = {}
        for topic, num in sorted(self.counts.items()):
            late = 1e3 * np.array(self._late.get(topic, []))
            p50, p99 = np.percentile(late, [50, 99]).tolist() if len(late) else (None, None)
            found[topic] = {"messages": num, "p50_ms": p50, "p99_ms": p99}
        return found


def share_answered(outputs: set[int], inputs: set[int]) -> float | None:
    """Return the share of input stamps that an output bears; None without inputs."""
    return len(outputs & inputs) / len(inputs) if inputs else None
