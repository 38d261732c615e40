"""What still has to go to one browser: only the newest of each kind, so that none falls behind."""

from __future__ import annotations

from typing import NamedTuple


class Outgoing(NamedTuple):
    """A message and the slot it came from."""

    slot: str
    message: str | bytes


class Outbox:
    """Holds one message a slot; a newer one takes the place of one not yet sent.

    So a slow browser sees fewer pictures, not older ones, and takes no more memory.

    Attributes:
        num_dropped: Messages that a newer one replaced.
    """

    def __init__(self) -> None:
        """Start empty."""
        self.num_dropped = 0
        self._waiting: dict[str, str | bytes] = {}

    def __len__(self) -> int:
        """Return how many messages wait."""
        return len(self._waiting)

    def put(self, slot: str, message: str | bytes) -> None:
        """Add a message; it keeps the place in line of the one it replaces."""
        self.num_dropped += slot in self._waiting
        self._waiting[slot] = message

    def take(self) -> Outgoing | None:
        """Return what has waited longest, and forget it; None if nothing waits."""
        for slot in self._waiting:
            return Outgoing(slot, self._waiting.pop(slot))
        return None
