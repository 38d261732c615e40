"""Waiting for those who listen and answer, so that a slow machine only takes longer.

Simulated time starts once those who are named listen (`Audience`).
The simulation goes on only while every named topic has been heard within `lag_s` of simulated
time. A wait is bounded: after `timeout_s` of real time it goes on without the late one, which is
then left out until it is heard again.
"""

from __future__ import annotations

from collections.abc import Iterable


class Audience:
    """Who has to listen before time starts; nothing here reads a clock.

    Args:
        names: Full names of nodes.
        settle_s: Everybody is there once nothing has changed for so long, real time: a node finds
            our topics one after the other, and a little after we have found it.
    """

    def __init__(self, names: Iterable[str], settle_s: float) -> None:
        self._names = frozenset(names)
        self._settle_s = settle_s
        self._seen: tuple[frozenset[str], int, int] | None = None
        self._since = 0.0

    def is_there(self, now: float, names: Iterable[str], num_known: int, num_matched: int) -> bool:
        """Tell whether everybody listens.

        Args:
            now: Real time, s.
            names: Full names of the nodes that subscribe to us.
            num_known: How many subscriptions they have, as the graph says.
            num_matched: How many our publishers have found.
        """
        seen = (frozenset(names), num_known, num_matched)
        if seen != self._seen:
            self._seen, self._since = seen, now
        if self.missing or num_matched < num_known:
            return False
        return now - self._since >= self._settle_s

    @property
    def missing(self) -> list[str]:
        """Names of those who do not listen yet."""
        return sorted(self._names - (self._seen[0] if self._seen else frozenset()))


class Pace:
    """Who has answered when, in simulated time; nothing here reads a clock.

    Args:
        topics: Names to wait for; one counts from its first message on.
        lag_s: How far simulated time may run ahead of the last answer.
        timeout_s: Longest wait, real time.
        from_start: Those of the names that count from time 0 on: they are known to listen.
    """

    def __init__(
        self,
        topics: Iterable[str],
        lag_s: float,
        timeout_s: float,
        from_start: Iterable[str] = (),
    ) -> None:
        known = frozenset(from_start)
        self._at_start = {topic: 0 if topic in known else None for topic in topics}
        self._answered_ns: dict[str, int | None] = dict(self._at_start)
        self._lag_ns = round(lag_s * 1e9)
        self._timeout_s = timeout_s
        self._given_up: set[str] = set()
        self._waiting_since: float | None = None

    def heard(self, topic: str, stamp_ns: int) -> bool:
        """Note an answer at a simulated time; an older one after a newer changes nothing.

        Returns:
            Whether it had been given up and is back.
        """
        self._answered_ns[topic] = max(stamp_ns, self._answered_ns[topic] or 0)
        is_back = topic in self._given_up
        self._given_up.discard(topic)
        return is_back

    def restart(self) -> None:
        """Forget all answers: time went back to its start."""
        self._answered_ns = dict(self._at_start)
        self._given_up.clear()
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
            self._given_up.add(topic)
        self._waiting_since = None
        return late
