"""Says in the log what a localizer's diagnostics say, when it changes."""

from __future__ import annotations

from collections.abc import Callable

from floornav_common.ros.diagnostics import OK, Status
from floornav_common.ros.node import FloornavNode

_SETTLED_NS = 1_000_000_000


class StateLog:
    """Logs a status that has lasted for a second and is another one than was logged last.

    Args:
        node: The node.
        check: Returns the status now.
    """

    def __init__(self, node: FloornavNode, check: Callable[[], Status]) -> None:
        """Begin to look."""
        self._node, self._check = node, check
        self._said = self._new = (b"", "")
        self._since_ns = 0
        node.time.on_look(self._look)

    def _look(self) -> None:
        status, now_ns = self._check(), self._node.time.steady_ns()
        key = (status.level, status.message.partition(":")[0])
        if key != self._new:
            self._new, self._since_ns = key, now_ns
        if key == self._said or now_ns - self._since_ns < _SETTLED_NS:
            return
        self._said = key
        logger = self._node.get_logger()
        if status.level == OK:
            logger.info(status.message)
        else:
            logger.warning(status.message)
