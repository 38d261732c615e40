"""Messages of one stamp, put together and handed on as a node's time goes by."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from floornav_common.ros.node import FloornavNode
from multi_localizer.stamp_groups import StampGroups


class StampedInput:
    """Collects what has one stamp, and hands it on once it is whole or has waited long enough.

    Args:
        node: Whose time it is.
        wait_s: How long what has one stamp waits for the rest of it.
        take: Called with a stamp and the values by key, the oldest first.

    Attributes:
        groups: What waits; to be cleared when the clock jumps back.
    """

    def __init__(
        self, node: FloornavNode, wait_s: float, take: Callable[[int, dict[str, Any]], None]
    ) -> None:
        """Begin to look for what has waited long enough."""
        self.groups = StampGroups(round(wait_s * 1e9))
        self._time, self._take = node.time, take
        node.time.on_look(lambda: self._hand_on(self.groups.overdue(self._time.steady_ns())))

    def add(self, key: str, stamp_ns: int, value: Any) -> None:
        """Take a value."""
        self._hand_on(self.groups.add(key, stamp_ns, value, self._time.steady_ns()))

    def _hand_on(self, groups: list[tuple[int, dict[str, Any]]]) -> None:
        for stamp_ns, values in groups:
            self._take(stamp_ns, values)
