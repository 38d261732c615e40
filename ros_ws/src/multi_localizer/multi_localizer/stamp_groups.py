"""What is seen at one moment comes in several messages of one stamp: put together again."""

from __future__ import annotations

from typing import Any

_MAX_OPEN = 20
_LATE_IN_A_ROW = 5
_ALONE_IN_A_ROW = 3


class StampGroups:
    """Collects values by stamp until all that usually come are there, or time is up.

    What never comes with the stamp of something else, as of cameras that are not triggered
    together, is not waited for with it after some groups. Groups leave in the order of their
    stamps. What comes for a group that has left is late and
    does not count, unless nothing else comes any more: after the late values of several moments in
    a row the stamps were set back, and all begins anew.

    Args:
        wait_ns: How long a group waits for the rest.

    Attributes:
        num_late: Values that came too late.
        num_parted: Of these, values whose stamp is that of a group that has left without them.
    """

    def __init__(self, wait_ns: int) -> None:
        self._wait_ns = wait_ns
        self.num_late, self.num_parted = 0, 0
        self.clear()

    def clear(self) -> None:
        """Forget what waits: the clock jumped back."""
        self._open: dict[int, dict[str, Any]] = {}
        self._since_ns: dict[int, int] = {}
        self._usual: dict[str, int] = {}
        self._late: set[int] = set()
        self._left_ns: int | None = None
        self._left: dict[int, tuple[str, ...]] = {}
        self._missed: dict[tuple[str, str], int] = {}

    def add(self, key: str, stamp_ns: int, value: Any, now_ns: int) -> list[tuple[int, dict]]:
        """Take a value; return the groups that are ready now, the oldest first.

        Args:
            key: What it is; the second of one key and stamp does not count.
            stamp_ns: Its stamp.
            value: The value.
            now_ns: Any clock that goes on.
        """
        is_late = self._is_late(stamp_ns)
        self._note_together(key, (*self._open.get(stamp_ns, ()), *self._left.get(stamp_ns, ())))
        self._usual[key] = max(stamp_ns, self._usual.get(key, stamp_ns))
        if is_late:
            self.num_parted += stamp_ns in self._left and key not in self._left[stamp_ns]
            return []
        self._open.setdefault(stamp_ns, {}).setdefault(key, value)
        self._since_ns.setdefault(stamp_ns, now_ns)
        complete = [t for t, group in self._open.items() if self._is_complete(t, group)]
        return self._leave(max(complete)) if complete else self.overdue(now_ns)

    def overdue(self, now_ns: int) -> list[tuple[int, dict]]:
        """Return the groups that have waited long enough, and those before them."""
        late = [t for t, since in self._since_ns.items() if now_ns - since >= self._wait_ns]
        if len(self._open) > _MAX_OPEN:
            late.append(min(self._open))
        return self._leave(max(late)) if late else []

    def _is_late(self, stamp_ns: int) -> bool:
        """Count a late value; forget all if only such have come for long enough."""
        if self._left_ns is None or stamp_ns > self._left_ns:
            self._late.clear()
            return False
        self._late.add(stamp_ns)
        if len(self._late) > _LATE_IN_A_ROW:
            self.clear()
            return False
        self.num_late += 1
        return True

    def _is_complete(self, stamp_ns: int, group: dict[str, Any]) -> bool:
        """Tell whether all keys that came of late are there; one long silent is not waited for."""
        oldest = stamp_ns - 10 * self._wait_ns
        missing = [k for k, newest in self._usual.items() if newest >= oldest and k not in group]
        return not any(self._is_worth_waiting(present, k) for k in missing for present in group)

    def _is_worth_waiting(self, present: str, missing: str) -> bool:
        return self._missed.get((present, missing), 0) < _ALONE_IN_A_ROW

    def _note_together(self, key: str, others: tuple[str, ...]) -> None:
        for other in others:
            self._missed.pop((key, other), None)
            self._missed.pop((other, key), None)

    def _leave(self, newest_ns: int) -> list[tuple[int, dict]]:
        ready = sorted(t for t in self._open if t <= newest_ns)
        self._left_ns = newest_ns
        left = {stamp_ns: self._open.pop(stamp_ns) for stamp_ns in ready}
        for stamp_ns, group in left.items():
            del self._since_ns[stamp_ns]
            self._note_missing(stamp_ns, group)
        kept = [*self._left.items(), *((t, tuple(group)) for t, group in left.items())]
        self._left = dict(kept[-_MAX_OPEN:])
        return list(left.items())

    def _note_missing(self, stamp_ns: int, group: dict[str, Any]) -> None:
        """Count what is not in a group though it has come with a later stamp."""
        for key, newest in self._usual.items():
            if key not in group and newest > stamp_ns:
                for present in group:
                    self._missed[present, key] = self._missed.get((present, key), 0) + 1
