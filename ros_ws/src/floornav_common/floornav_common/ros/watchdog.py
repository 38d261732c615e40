"""Inputs that must keep coming: silence counted by the rule of time, and said on /diagnostics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floornav_common.ros.diagnostics import ERROR, OK, STALE, Status
from floornav_common.ros.qos import publisher_names
from floornav_common.time_watch import Deadline

if TYPE_CHECKING:
    from floornav_common.ros.node import FloornavNode

_LOG_PERIOD_NS = 10_000_000_000


class Watchdog:
    """Watches one input of a node; part `input <topic>` of its diagnostics.

    Args:
        node: The node.
        topic: Full name of the topic, or what else the input is called.
        timeout_s: Silence allowed, in simulated seconds with `use_sim_time`.
    """

    def __init__(self, node: FloornavNode, topic: str, timeout_s: float) -> None:
        """Start counting."""
        self.topic = topic
        self._node = node
        self._deadline = Deadline(int(timeout_s * 1e9))
        node.time.on_restart(self._deadline.restart)
        node.diagnostics.add(f"input {topic}", self.status)
        node.time.on_look(self._say_change)
        self._has_said_silence, self._refusal = False, ""
        self._said_ns: int | None = None

    def feed(self) -> None:
        """Note that the input came."""
        self._refusal = ""
        self._deadline.feed(self._node.time.read_ns())

    def refuse(self, why: str) -> None:
        """Note that the input came and cannot be used: it counts as heard, not as well."""
        self.feed()
        self._refusal = why

    def set_timeout(self, timeout_s: float) -> None:
        """Change the silence allowed, s."""
        self._deadline.timeout_ns = int(timeout_s * 1e9)

    @property
    def is_fresh(self) -> bool:
        """Whether the input came within the timeout, and time goes on."""
        time = self._node.time
        is_late = self._deadline.is_over(time.read_ns())
        return self._deadline.has_heard and not is_late and not time.is_stopped

    def _say_change(self) -> None:
        """Say once in the log that the input is missing, and once that it came.

        One that comes and goes, as on a machine too slow for it, is said once in ten seconds.
        """
        is_missing = not self.is_fresh and self._deadline.is_over(self._node.time.read_ns())
        now_ns = self._node.time.steady_ns()
        is_soon = self._said_ns is not None and now_ns - self._said_ns < _LOG_PERIOD_NS
        if is_missing and not self._has_said_silence and not is_soon:
            self._said_ns = now_ns
            self._node.get_logger().warning(f"{self.topic}: {self.status().message}")
        elif self._has_said_silence and self.is_fresh and not self._refusal:
            self._node.get_logger().info(f"{self.topic}: arriving")
        else:
            return
        self._has_said_silence = is_missing

    def status(self) -> Status:
        """Return OK, ERROR for what is refused, or STALE with what is missing and who sends it."""
        time = self._node.time
        silence_s = self._deadline.silence_ns(time.read_ns()) / 1e9
        values = {"silent for (s)": f"{silence_s:.2f}", "timeout (s)": self._timeout_s}
        if self.is_fresh and self._refusal:
            return Status(ERROR, f"refused: {self._refusal}", values)
        if self.is_fresh:
            return Status(OK, "arriving", values)
        if time.is_stopped:
            return Status(STALE, "/clock stands still", values)
        others = ", ".join(publisher_names(self._node, self.topic)) or "nobody"
        what = "no longer arriving" if self._deadline.has_heard else "never arrived"
        return Status(STALE, f"{what}; published by {others}", values)

    @property
    def _timeout_s(self) -> float:
        return self._deadline.timeout_ns / 1e9
