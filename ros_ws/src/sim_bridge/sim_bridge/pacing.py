"""Waiting for those who answer, so that a slow machine only takes longer.

The simulation goes on only while every named topic has been heard within `lag_s` of simulated
time. A wait is bounded: after `timeout_s` of real time it goes on without the late one, which is
then left out until it is heard again.
"""

from __future__ import annotations

from collections.abc import Iterable


class Pace:
    """Who has answered when, in simulated time; nothing here reads a clock.

    Args:
        topics: Names to wait for; one counts from its first message on.
        lag_s: How far simulated time may run ahead of the last answer.
        timeout_s: Longest wait, real time.
    """

    def __init__(self, topics: Iterable[str], lag_s: float, timeout_s: float) -> None:
        self._answered_ns: dict[str, int | None] = dict.fromkeys(topics)
        self._lag_ns = round(lag_s * 1e9)
        self._timeout_s = timeout_s
        self._waiting_since: float | None = None

    def heard(self, topic: str, stamp_ns: int) -> None:
        """Note an answer at a simulated time."""
        self._answered_ns[topic] = stamp_ns

    def restart(self) -> None:
        """Forget all answers: time went back to its start."""
        self._answered_ns = dict.fromkeys(self._answered_ns)
        self._waiting_since = None

    def late(self, stamp_ns: int) -> list[str]:
        """Return the topics that simulated time waits for."""
        return [
            topic
            for topic, answered in self._answered_ns.items()
            if answered is not None and stamp_ns - answered >= self._lag_ns
        ]

    def give_up(self, stamp_ns: int, now: float) -> list[str]:
        """Return the topics that were waited for too long at a real time (s), and drop them."""
        late = self.late(stamp_ns)
        if not late:
            self._waiting_since = None
            return []
        if self._waiting_since is None:
            self._waiting_since = now
        if now - self._waiting_since < self._timeout_s:
            return []
        for topic in late:
            self._answered_ns[topic] = None
        self._waiting_since = None
        return late
