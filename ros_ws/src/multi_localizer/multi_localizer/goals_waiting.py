"""Goals that were seen: kept until the mask of their moment comes, and counted once each."""

from __future__ import annotations

from multi_localizer.goal_evidence import GoalsSeen

_S = 1_000_000_000
_MOST = 50


class GoalsWaiting:
    """Keeps goals until the mask of their moment comes; knows which have counted."""

    def __init__(self) -> None:
        self._waiting: list[GoalsSeen] = []
        self._counted_ns: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, seen: GoalsSeen) -> None:
        """Keep one; the oldest of too many are forgotten."""
        self._waiting = [*self._waiting, seen][-_MOST:]

    def take(self, stamp_ns: int, max_skew_s: float) -> list[GoalsSeen]:
        """Return those of a moment, the oldest first; forget them and all that are older."""
        skew_ns = max_skew_s * _S
        near = [s for s in self._waiting if abs(s.stamp_ns - stamp_ns) <= skew_ns]
        self._waiting = [s for s in self._waiting if s.stamp_ns - stamp_ns > skew_ns]
        return sorted(near, key=lambda s: s.stamp_ns)

    def count(self, seen: GoalsSeen, new_after_s: float) -> float:
        """Return how much of what is seen is new, 0 to 1; it has counted then."""
        last_ns = self._counted_ns.get(seen.kind)
        if last_ns is not None and seen.stamp_ns <= last_ns:
            return 0.0
        self._counted_ns[seen.kind] = seen.stamp_ns
        return 1.0 if last_ns is None else min((seen.stamp_ns - last_ns) / (new_after_s * _S), 1.0)

    def clear(self) -> None:
        """Forget all."""
        self._waiting, self._counted_ns = [], {}
