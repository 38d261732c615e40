"""/diagnostics: one status a part of a node, once a second and whenever it changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from floornav_common.ros.qos import RELIABLE_QOS, create_publisher

OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR, DiagnosticStatus.STALE
)  # fmt: skip
_PERIOD_NS = 1_000_000_000


@dataclass(frozen=True)
class Status:
    """How one part is.

    Attributes:
        level: `OK`, `WARN`, `ERROR` or `STALE` of this module.
        message: One line; a new one is published at once.
        values: Numbers beside it; new ones wait for the next second.
    """

    level: bytes
    message: str
    values: Mapping[str, Any] = field(default_factory=dict)


class Diagnostics:
    """The parts of one node, each named `<full node name>: <part>`.

    Args:
        node: Node to publish with.
    """

    def __init__(self, node: Node) -> None:
        """Create the publisher."""
        self._node = node
        self._publisher = create_publisher(node, DiagnosticArray, "/diagnostics", RELIABLE_QOS)
        self._checks: dict[str, Callable[[], Status]] = {}
        self._said: dict[str, tuple[bytes, str]] = {}
        self._all_said_ns: int | None = None

    def add(self, part: str, check: Callable[[], Status]) -> None:
        """Add a part; `check` is asked ten times a second and must be quick."""
        self._checks[part] = check

    def set(self, part: str, status: Status) -> None:
        """Say how a part is, for parts that know it themselves."""
        self._checks[part] = lambda: status

    def look(self, steady_ns: int) -> None:
        """Publish the parts that changed; all of them once a second."""
        now = {part: check() for part, check in self._checks.items()}
        is_time = self._all_said_ns is None or steady_ns - self._all_said_ns >= _PERIOD_NS
        if is_time:
            self._all_said_ns = steady_ns
        due = {p: s for p, s in now.items() if is_time or self._said.get(p) != (s.level, s.message)}
        self._said = {part: (status.level, status.message) for part, status in now.items()}
        if due:
            self._publish(due)

    def _publish(self, statuses: Mapping[str, Status]) -> None:
        name = self._node.get_fully_qualified_name()
        msg = DiagnosticArray()
        msg.header.stamp = self._node.get_clock().now().to_msg()
        msg.status = [
            DiagnosticStatus(
                level=status.level,
                name=f"{name}: {part}",
                message=status.message,
                values=[KeyValue(key=k, value=str(v)) for k, v in status.values.items()],
            )
            for part, status in statuses.items()
        ]
        self._publisher.publish(msg)
