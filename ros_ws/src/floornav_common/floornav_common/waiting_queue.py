"""Stamped messages that wait, in stamp order, for something to cover their stamps."""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(order=True, frozen=True, slots=True)
class Waiting:
    """A message in the queue.

    Attributes:
        stamp_ns: Its stamp.
        number: Order of arrival among equal stamps.
        since_ns: When it came, on the clock silence is counted on.
        msg: The message.
    """

    stamp_ns: int
    number: int
    since_ns: int = field(compare=False)
    msg: Any = field(compare=False)


class WaitingQueue:
    """Bounded queue in stamp order; its head leaves when covered, or too late, or pushed out.

    Args:
        capacity: Greatest number of messages; the oldest stamp goes first.
    """

    def __init__(self, capacity: int) -> None:
        """Start empty."""
        self._capacity = capacity
        self._waiting: list[Waiting] = []
        self._num_pushed = 0

    def __len__(self) -> int:
        """Return how many messages wait."""
        return len(self._waiting)

    def push(self, stamp_ns: int, now_ns: int, msg: Any) -> list[Waiting]:
        """Let a message wait; return those pushed out by it."""
        self._num_pushed += 1
        insort(self._waiting, Waiting(stamp_ns, self._num_pushed, now_ns, msg))
        num_over = max(len(self._waiting) - self._capacity, 0)
        out, self._waiting = self._waiting[:num_over], self._waiting[num_over:]
        return out

    def pop_head(self, is_ready: Callable[[Waiting], bool]) -> Waiting | None:
        """Return and remove the head if it is ready."""
        if not self._waiting or not is_ready(self._waiting[0]):
            return None
        return self._waiting.pop(0)

    def pop_late(self, now_ns: int, timeout_ns: int) -> list[Waiting]:
        """Return and remove all that have waited for longer than the timeout."""
        late = [w for w in self._waiting if now_ns - w.since_ns > timeout_ns]
        self._waiting = [w for w in self._waiting if now_ns - w.since_ns <= timeout_ns]
        return late

    def clear(self) -> int:
        """Forget all; return how many there were."""
        num, self._waiting = len(self._waiting), []
        return num
