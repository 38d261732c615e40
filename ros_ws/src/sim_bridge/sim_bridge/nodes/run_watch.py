"""What /diagnostics says of a run: how fast time goes, and who else publishes `/clock`."""

from __future__ import annotations

from collections import Counter

from floornav_common.ros.diagnostics import ERROR, OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.time_watch import Throttle
from sim_bridge.real_time import RealTime

_SAY_PERIOD_NS, _LOOK_PERIOD_NS = 30_000_000_000, 1_000_000_000


class RunWatch:
    """Parts `real time` and `clock topic` of the diagnostics, said in the log too.

    Args:
        node: The node that publishes `/clock`.
    """

    def __init__(self, node: FloornavNode) -> None:
        """Start watching."""
        self._node, self._real_time = node, RealTime()
        self._looks, self._slow = Throttle(_LOOK_PERIOD_NS), Throttle(_SAY_PERIOD_NS)
        self._other, self._was_nameless = "", False
        node.diagnostics.set("real time", Status(OK, "not measured yet"))
        node.diagnostics.set("clock topic", Status(OK, "only published here"))

    def look(self, sim_ns: int, asked: float, *, is_held: bool) -> None:
        """Look at the time, ten times a second or so.

        Args:
            sim_ns: Simulated time.
            asked: The factor asked for; 0 = as fast as it goes.
            is_held: True while time stands still on purpose.
        """
        now_ns = self._node.time.steady_ns()
        if is_held:
            self._real_time.restart()
        else:
            self._real_time.look(now_ns * 1e-9, sim_ns * 1e-9)
        if self._looks.is_due(now_ns):
            self._judge_speed(now_ns, asked)
            self._judge_clock()

    def _judge_speed(self, now_ns: int, asked: float) -> None:
        text, factor = self._real_time.complaint(asked), self._real_time.factor
        if text and self._slow.is_due(now_ns):
            self._node.get_logger().warning(
                f"{text}: the machine is busy, or time waits for answers; lower real_time_factor"
            )
        message = text or ("not measured yet" if factor is None else "as fast as asked")
        values = {} if factor is None else {"times real time": f"{factor:.2f}"}
        status = Status(WARN if text else OK, message, values)
        self._node.diagnostics.set("real time", status)

    def _judge_clock(self) -> None:
        # One of the same name as ours is another all the same.
        infos = self._node.get_publishers_info_by_topic("/clock")
        names = Counter(f"{i.node_namespace.rstrip('/')}/{i.node_name}" for i in infos)
        names[self._node.get_fully_qualified_name()] -= 1
        there = [name for name, num in names.items() if num > 0]
        others = sorted(name for name in there if "_UNKNOWN_" not in name)
        if there and not others and self._was_nameless:
            others = ["a node that has not given its name"]
        # The graph hears a node's name a moment after its publisher: that is waited for, one look.
        self._was_nameless = bool(there)
        text = f"/clock is also published by {', '.join(others)}: end one of them" if others else ""
        if text and text != self._other:
            self._node.get_logger().error(text)
        self._other = text
        status = Status(ERROR, text) if text else Status(OK, "only published here")
        self._node.diagnostics.set("clock topic", status)
