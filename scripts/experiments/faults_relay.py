"""The relay of `evaluate.py faults`: a node between the simulator and those who hear it.

The simulator's topics are remapped to `raw/...`; the relay sends them on under their own names, as
they are or changed. Commands go the other way. What arrives and leaves is noted with the
simulator's own time, whatever the nodes are told that it is.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from experiments.faults_changes import Change, shift_stamps
from floornav_common.ros.messages import stamp_to_ns

CLOCK = "/clock"
_RESTART_NS = 1_000_000_000


@dataclass
class Passed:
    """A topic that goes through the relay.

    Attributes:
        kind: Message class.
        source: Where it is heard.
        target: Where it is sent on.
        change: What is done to it; None to pass it as it is.
        last_ns: Simulator's time at which one went on unchanged last.
        changed_ns: At which the first one was changed since `change` was set; None before.
        num: How many came.
    """

    kind: type
    source: str
    target: str
    change: Change | None = None
    last_ns: int = 0
    changed_ns: int | None = None
    num: int = 0
    publisher: Any = field(default=None, repr=False)


def raw_name(topic: str) -> str:
    """Return the name under which the simulator publishes a topic."""
    return f"/raw/{topic.lstrip('/')}"


def through_qos(topic: str) -> QoSProfile:
    """Return a profile that loses nothing on either side."""
    is_latched, is_clock = topic == "/tf_static", topic == CLOCK
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=100,
        reliability=ReliabilityPolicy.BEST_EFFORT if is_clock else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


class FaultRelay(Node):
    """Passes topics on.

    Args:
        topics: Message class by name as the nodes know it; the simulator's are below `raw/`.
        commands: Names that go the other way, to the simulator.

    Attributes:
        now_ns: The simulator's time; it goes on where a simulator ended and another started.
        base_ns: What the present simulator's own time is counted from.
        shift_ns: By how much all stamps and the clock are moved.
        clock_shift_ns: By how much the clock alone is moved, beside that.
        passed: By name.
        on_sent: By name, called with the simulator's time and each message that goes on.
    """

    def __init__(self, topics: dict[str, type], commands: dict[str, type]) -> None:
        super().__init__("fault_relay")
        self.now_ns = self.base_ns = self.shift_ns = self.clock_shift_ns = 0
        self.passed: dict[str, Passed] = {}
        self.on_sent: dict[str, Callable[[int, Any], None]] = {}
        self._late: list[tuple[int, int, str, Any]] = []
        self._count = itertools.count()
        self._statics: bytes | None = None
        for name, kind in topics.items():
            self.add(name, kind)
        for name, kind in commands.items():
            self._pass(name, Passed(kind, name, raw_name(name)))

    def set_change(self, name: str, change: Change | None) -> None:
        """Do something to a topic from now on, or nothing any more."""
        passed = self.passed[name]
        passed.change, passed.changed_ns = change, None

    def withhold_statics(self) -> None:
        """Take the places of sensors away from nodes that start from now on."""
        passed = self.passed["/tf_static"]
        self.destroy_publisher(passed.publisher)
        passed.publisher = None

    def give_statics(self) -> None:
        """Give them again."""
        passed = self.passed["/tf_static"]
        if passed.publisher is None:
            passed.publisher = self.create_publisher(
                passed.kind, passed.target, through_qos("/tf_static")
            )
        if self._statics is not None:
            passed.publisher.publish(self._statics)

    def add(self, name: str, kind: type) -> None:
        """Pass on one more of the simulator's topics."""
        if name not in self.passed:
            self._pass(name, Passed(kind, raw_name(name), name))

    def _pass(self, name: str, passed: Passed) -> None:
        self.passed[name] = passed
        passed.publisher = self.create_publisher(passed.kind, passed.target, through_qos(name))
        self.create_subscription(
            passed.kind, passed.source, lambda data: self._take(name, data), through_qos(name),
            raw=True,
        )  # fmt: skip

    def _take(self, name: str, data: bytes) -> None:
        passed = self.passed[name]
        passed.num += 1
        if name == CLOCK:
            self._tick(stamp_to_ns(deserialize_message(data, passed.kind).clock))
        elif name == "/tf_static":
            self._statics = data
        shift_ns = self.shift_ns + (self.clock_shift_ns if name == CLOCK else 0)
        is_sensor = passed.source != name
        if passed.change is None and not (shift_ns and is_sensor):
            passed.last_ns = self.now_ns
            self._send(name, data)
            return
        self._send_changed(name, deserialize_message(data, passed.kind), shift_ns * is_sensor)

    def _tick(self, clock_ns: int) -> None:
        if self.base_ns + clock_ns < self.now_ns - _RESTART_NS:  # another simulator
            self.base_ns = self.now_ns
        self.now_ns = max(self.now_ns, self.base_ns + clock_ns)
        self._send_late()

    def _send_changed(self, name: str, msg: Any, shift_ns: int) -> None:
        passed = self.passed[name]
        if shift_ns:
            shift_stamps(msg, shift_ns)
        if passed.change is None:
            passed.last_ns = self.now_ns
            self._send(name, msg)
            return
        if passed.changed_ns is None:
            passed.changed_ns = self.now_ns
        for delay_ns, each in passed.change(msg, self.now_ns):
            if delay_ns:
                late = (self.now_ns + delay_ns, next(self._count), name, each)
                heapq.heappush(self._late, late)
            else:
                self._send(name, each)

    def _send_late(self) -> None:
        while self._late and self._late[0][0] <= self.now_ns:
            *_, name, msg = heapq.heappop(self._late)
            self._send(name, msg)

    def _send(self, name: str, msg: Any) -> None:
        passed = self.passed[name]
        if passed.publisher is not None:
            passed.publisher.publish(msg)
        if name in self.on_sent:
            told = deserialize_message(msg, passed.kind) if isinstance(msg, bytes) else msg
            self.on_sent[name](self.now_ns, told)
