"""Notes between the team's robots, by which each learns how far the others' clocks are off.

In: `/<namespace>/team/clock` of each teammate (TimeReference). Out: `team/clock`, one a second for
each teammate: `header.stamp` this robot's clock, `header.frame_id` its namespace, `source` whom it
is for, `time_ref` what the teammate's clock should read by now (0: not heard yet).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sensor_msgs.msg import TimeReference

from floornav_common.ros.messages import ns_to_stamp, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher, create_subscription
from multi_localizer.clock_offsets import TeammateClock
from multi_localizer.team_lists import TeammateList

_PERIOD_NS = 1_000_000_000


class TeamClocks:
    """Writes and reads the notes.

    Args:
        node: The node.
        own: This robot's namespace.
        clocks: Of the teammates, by namespace.

    Attributes:
        lists: The team as each teammate was told, by namespace.
    """

    def __init__(self, node: FloornavNode, own: str, clocks: Mapping[str, TeammateClock]) -> None:
        """Begin to write."""
        self._node, self._own, self._clocks = node, own, clocks
        self.lists = {name: TeammateList(name) for name in clocks}
        self._written_ns: int | None = None
        self._publisher = create_publisher(node, TimeReference, "team/clock", RELIABLE_QOS)
        self._subscriptions = [
            create_subscription(
                node, TimeReference, f"/{name}/team/clock", self._reader(name, clock), RELIABLE_QOS
            )
            for name, clock in clocks.items()
        ]
        node.time.on_look(self._look)

    def _now_ns(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _look(self) -> None:
        steady_ns = self._node.time.steady_ns()
        if self._written_ns is not None and steady_ns - self._written_ns < _PERIOD_NS:
            return
        self._written_ns = steady_ns
        for name, clock in self._clocks.items():
            note = TimeReference(source=name)
            now_ns = self._now_ns()
            note.header.stamp, note.header.frame_id = ns_to_stamp(now_ns), self._own
            note.time_ref = ns_to_stamp(max(clock.echo_ns(now_ns) or 0, 0))
            self._publisher.publish(note)

    def _reader(self, name: str, clock: TeammateClock) -> Any:
        def read(note: Any) -> None:
            self.lists[name].take(note.source)
            if note.source == self._own:
                echo_ns = stamp_to_ns(note.time_ref) or None
                clock.take_note(stamp_to_ns(note.header.stamp), echo_ns, self._now_ns())

        return read
