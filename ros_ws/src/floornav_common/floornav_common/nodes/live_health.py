"""What the live view says of the robot's nodes and of what it waits for."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray

from floornav_common.live_view.encoding import text_message
from floornav_common.nodes.live_topics import LiveTopics
from floornav_common.ros.live_drawings import level_of
from floornav_common.ros.live_inputs import LiveInput
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, copy_qos
from floornav_common.time_watch import Throttle
from floornav_common.transform_errors import TransformUnavailable

_STALE = 3
_PERIOD_NS = 500_000_000
_GONE_S, _MAX_PARTS = 5.0, 300
_DEPTH = 100


class LiveHealth:
    """Diagnostics of all nodes, the robot's pose and its age, and words for what is missing.

    Args:
        node: The node.
        topics: What is drawn.
        silent_after_s: An input is named that is silent for longer, s.
    """

    def __init__(self, node: FloornavNode, topics: LiveTopics, silent_after_s: float) -> None:
        """Subscribe."""
        self._node, self._topics = node, topics
        self.silent_after_s = silent_after_s
        qos = copy_qos(RELIABLE_QOS)
        qos.depth = _DEPTH
        self._input = LiveInput(node, DiagnosticArray, "/diagnostics", qos, keep=_DEPTH)
        self._parts: dict[str, tuple[int, str, int]] = {}
        self._throttle = Throttle(_PERIOD_NS)
        self._pose_problem = "no transform yet"
        node.time.on_restart(self._parts.clear)

    def open(self) -> None:
        """Listen, from nothing."""
        self._parts.clear()
        self._input.open()

    def close(self) -> None:
        """Listen no more."""
        self._input.close()

    def news(self) -> dict[str, str]:
        """Return the robot's pose, and twice a second the rest, by slot."""
        now_ns = self._node.time.steady_ns()
        for array in self._input.messages:
            for status in array.status:
                if status.name in self._parts or len(self._parts) < _MAX_PARTS:
                    self._parts[status.name] = level_of(status), status.message, now_ns
        self._input.messages.clear()
        found = {"pose": self._pose()}
        if self._throttle.is_due(now_ns):
            found["diagnostics"] = self._diagnostics(now_ns)
            found["health"] = self._health()
        return found

    def _pose(self) -> str:
        """Return where the robot is, by the newest transforms."""
        base = self._node.frames.base
        pose = self._topics.frames.find(base)
        self._pose_problem = self._topics.frames.why_not(base)
        if pose is None:
            return text_message("pose", pose=None)
        age_s = self._pose_age_s()
        if abs(age_s) > self.silent_after_s:
            self._pose_problem = f"the robot's pose is {age_s:.1f} s old"
        values = {"x": round(pose.x, 3), "y": round(pose.y, 3), "yaw": round(pose.yaw, 4)}
        return text_message("pose", pose=values, age=round(age_s, 2))

    def _pose_age_s(self) -> float:
        """Return how old the newest pose is, 0 if nothing of it moves, s."""
        frames = self._node.frames
        try:
            stamp_ns = self._node.transforms.buffer.newest_common_stamp(frames.map, frames.base)
        except TransformUnavailable:
            return 0.0
        return (self._node.get_clock().now().nanoseconds - stamp_ns) * 1e-9 if stamp_ns else 0.0

    def _diagnostics(self, now_ns: int) -> str:
        rows: list[dict[str, Any]] = []
        for name, (level, message, heard_ns) in sorted(self._parts.items()):
            silent_s = (now_ns - heard_ns) * 1e-9
            is_gone = silent_s > _GONE_S
            text = f"silent for {silent_s:.0f} s; before: {message}" if is_gone else message
            rows.append({"name": name, "level": _STALE if is_gone else level, "message": text})
        return text_message("diagnostics", parts=rows)

    def _health(self) -> str:
        time = self._node.time
        ages = [(each.topic, each.age_s) for each in self._topics.inputs]
        return text_message(
            "health",
            problems=self.problems(),
            inputs=[{"topic": t, "age": None if a is None else round(a, 1)} for t, a in ages],
            clock=round(self._node.get_clock().now().nanoseconds * 1e-9, 1),
            simulated=time.is_simulated,
        )

    def problems(self) -> list[str]:
        """Return what is missing or cannot be drawn, the first causes first."""
        found = []
        is_stopped = self._node.time.is_stopped
        if is_stopped:
            found.append("/clock stands still, or nobody publishes it")
        map_input, scan_input = self._topics.needed
        if map_input.age_s is None:
            found.append(map_input.missing(self.silent_after_s))
        if not (is_stopped and scan_input.age_s is not None):
            found.append(scan_input.missing(self.silent_after_s))
        if self._pose_problem and not is_stopped:
            found.append(f"no pose of the robot: {self._pose_problem}")
        found += self._topics.faults.values()
        base = self._node.frames.base
        # Without a pose nothing of the robot's is placed: said once.
        if not self._pose_problem:
            found += self._topics.frames.problems(self.silent_after_s, but=base)
        return [text for text in found if text]
