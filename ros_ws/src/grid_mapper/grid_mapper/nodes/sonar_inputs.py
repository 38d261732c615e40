"""Sonar topics of the mapping node: readings with where their sonars look."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sensor_msgs.msg import Range

from floornav_common.readings import RangeReading
from floornav_common.ros import messages
from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, copy_qos
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.time_watch import Deadline
from floornav_common.transform3 import Transform3
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.layers import SonarCounts
from grid_mapper.sonar_mount import infrared_warning

SONAR_QOS = copy_qos(SENSOR_QOS)
SONAR_QOS.depth = 100
"""A ring of sonars on one topic sends in bursts, which may come while a scan is matched."""

SILENT_NS = 5_000_000_000
"""A topic without a message for so long is named on the diagnostics."""

OnRange = Callable[[Any, str, RangeReading, Transform3], None]


class SonarInputs:
    """Calls back with `(msg, sensor, reading, T_target_sonar)` once TF covers the reading's stamp.

    Sonars of one topic are told apart by their frame_id. Infrared rangers are refused and named.

    Args:
        node: The node.
        topics: Topics to subscribe to.
        target_frame: Frame to bring the poses to.
        on_range: Called for each reading; a ValueError of it is said, and the reading left out.
        warn: Called with what to say, throttled.
        counts: Gives what became of readings.
    """

    def __init__(
        self,
        node: FloornavNode,
        topics: tuple[str, ...],
        target_frame: str,
        on_range: OnRange,
        warn: Callable[[str], None],
        counts: Callable[[], SonarCounts],
    ) -> None:
        """Subscribe."""
        self._on_range = on_range
        self._warn = warn
        self._counts = counts
        self._node = node
        self._sensors: set[str] = set()
        self._seen = (0, 0)
        self._infrared: set[str] = set()
        self._topics = [self._subscribe(node, topic, target_frame) for topic in topics]
        # Robots without sonars leave the default, and miss nothing.
        self._may_be_none = topics == GridMapperNodeConfig().sonar_topics
        self._deadlines = [Deadline(SILENT_NS) for _ in topics]
        self._counted = [0] * len(topics)
        for deadline in self._deadlines:
            node.time.on_restart(deadline.restart)
        node.diagnostics.add("sonars", self.status)

    def status(self) -> Status:
        """Return what was heard and what became of it."""
        counts = self._counts()
        values = {
            "sonars": len(self._sensors),
            "received": sum(t.num_received for t in self._topics),
            "placed": counts.placed,
            "saying nothing": counts.void,
            "counted": counts.counted,
            "without a pose": counts.unplaced,
        }
        placed, unplaced = self._seen
        self._seen = (counts.placed, counts.unplaced)
        if counts.unplaced > unplaced and counts.placed == placed:
            return Status(WARN, "no reading finds its pose: compare the stamps with scans", values)
        if self._infrared:
            return Status(WARN, infrared_warning(self._infrared), values)
        silent = self._silent()
        if silent:
            return Status(WARN, f"nothing heard on {', '.join(silent)}", values)
        return Status(OK, "readings arrive" if self._sensors else "no sonar is heard", values)

    def _silent(self) -> list[str]:
        """Return the topics that nothing came on of late, where something was to be expected."""
        now_ns, silent = self._node.time.read_ns(), []
        for k, (topic, deadline) in enumerate(zip(self._topics, self._deadlines, strict=True)):
            if topic.num_received > self._counted[k]:
                deadline.feed(now_ns)
                self._counted[k] = topic.num_received
            is_expected = deadline.has_heard or not self._may_be_none
            if deadline.is_over(now_ns) and is_expected:
                silent.append(topic.topic)
        return silent

    def _subscribe(
        self, node: FloornavNode, topic: str, target_frame: str
    ) -> TransformedSubscription:
        def on_message(msg: Any, T_target_sonar: Transform3) -> None:
            if msg.radiation_type == Range.INFRARED:
                self._refuse(msg.header.frame_id)
                return
            sensor = f"{topic} {msg.header.frame_id}"
            self._sensors.add(sensor)
            try:
                self._on_range(msg, sensor, messages.range_from_msg(msg), T_target_sonar)
            except ValueError as error:
                self._warn(f"{topic}, {msg.header.frame_id}: {error}")

        return TransformedSubscription(node, Range, topic, SONAR_QOS, target_frame, on_message)

    def _refuse(self, frame: str) -> None:
        """Name an infrared ranger once in the log; the diagnostics go on saying it."""
        if frame not in self._infrared:
            self._infrared.add(frame)
            self._node.get_logger().warning(infrared_warning((frame,)))
