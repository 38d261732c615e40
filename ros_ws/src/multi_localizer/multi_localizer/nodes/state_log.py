"""Says in the log what a localizer's diagnostics say, when it changes."""

from __future__ import annotations

import re
from collections.abc import Callable

from floornav_common.ros.diagnostics import OK, Status
from floornav_common.ros.node import FloornavNode

_DECIMALS = re.compile(r"\d+\.\d+")


class StateLog:
    """Logs a status that has lasted for a while and is another one than was logged last.

    Another one is one of another level, or whose words up to the first colon differ in more than
    decimal numbers.

    Args:
        node: The node.
        check: Returns the status now.
        what: Whose status it is, put before it.
        settled_s: How long a status has to last.
        period_s: At least this long between two lines.
        says_ok: Whether an OK is logged that nothing else went before.
    """

    def __init__(
        self,
        node: FloornavNode,
        check: Callable[[], Status],
        what: str = "",
        *,
        settled_s: float = 1.0,
        period_s: float = 0.0,
        says_ok: bool = True,
    ) -> None:
        """Begin to look."""
        self._node, self._check, self._what = node, check, what
        self._settled_ns, self._period_ns = round(settled_s * 1e9), round(period_s * 1e9)
        self._said = self._new = (b"", "")
        self._says_ok = says_ok
        self._since_ns = 0
        self._said_ns: int | None = None
        node.time.on_look(self._look)

    def _look(self) -> None:
        status, now_ns = self._check(), self._node.time.steady_ns()
        key = (status.level, _DECIMALS.sub("", status.message.partition(":")[0]))
        if key != self._new:
            self._new, self._since_ns = key, now_ns
        if key == self._said or now_ns - self._since_ns < self._settled_ns:
            return
        if self._said_ns is not None and now_ns - self._said_ns < self._period_ns:
            return
        is_first, self._said = self._said_ns is None, key
        if is_first and status.level == OK and not self._says_ok:
            return
        self._said_ns = now_ns
        text = f"{self._what}: {status.message}" if self._what else status.message
        logger = self._node.get_logger()
        if status.level == OK:
            logger.info(text)
        else:
            logger.warning(text)
