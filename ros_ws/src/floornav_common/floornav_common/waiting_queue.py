"""Stamped messages that wait, in stamp order, for something to cover their stamps.

`WaitingQueue` sorts those that wait; `StampOrder` keeps what leaves from running back in time.
"""

from __future__ import annotations

from bisect import insort
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
    """Bounded queue in stamp order; messages leave from its head, or too late, or pushed out.

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

    @property
    def head(self) -> Waiting | None:
        """The message with the oldest stamp, None if nobody waits."""
        return self._waiting[0] if self._waiting else None

    def pop_head(self) -> Waiting:
        """Return and remove the message with the oldest stamp."""
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


class StampOrder:
    """Tells stamps that follow the newest so far from those that come behind it.

    Args:
        num_jump: So many behind in a row are taken for stamps that jumped back, and accepted.
    """

    def __init__(self, num_jump: int) -> None:
        """Start with no stamp."""
        self._num_jump = num_jump
        self._newest_ns: int | None = None
        self._num_behind = 0

    def is_next(self, stamp_ns: int) -> bool:
        """Return whether a stamp is not older than the newest, and remember it if so."""
        if self._newest_ns is not None and stamp_ns < self._newest_ns:
            self._num_behind += 1
            if self._num_behind < self._num_jump:
                return False
        self._newest_ns, self._num_behind = stamp_ns, 0
        return True

    def restart(self) -> None:
        """Begin a new order: time jumped back."""
        self._newest_ns, self._num_behind = None, 0
