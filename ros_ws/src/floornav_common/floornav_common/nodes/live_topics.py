"""The topics that the live view shows, each made into what its page draws."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import Image, LaserScan, Range
from visualization_msgs.msg import MarkerArray

from floornav_common.live_view.config import LiveViewConfig
from floornav_common.nodes.map_frames import MapFrames
from floornav_common.ros import live_drawings as draw
from floornav_common.ros.arrays import from_field
from floornav_common.ros.live_inputs import LiveInput, stamped_input
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, SENSOR_QOS, copy_qos
from floornav_common.se2 import SE2
from floornav_common.time_watch import Throttle
from floornav_common.transform_errors import TransformUnavailable

Message = str | bytes
_SONARS_KEPT = 64
_NS = 1_000_000_000


class LiveTopics:
    """Listens to everything that is drawn, and makes messages of what is new.

    Args:
        node: The node.
        config: Which topics, and how often pictures.

    Attributes:
        faults: What cannot be drawn, by topic.
        frames: Where frames are on the map.
    """

    def __init__(self, node: FloornavNode, config: LiveViewConfig) -> None:
        """Subscribe."""
        self._node, self._config = node, config
        self.faults: dict[str, str] = {}
        self.frames = MapFrames(node)
        sonar_qos = copy_qos(SENSOR_QOS)
        sonar_qos.depth = _SONARS_KEPT
        self._sonars = [
            LiveInput(node, Range, topic, sonar_qos, keep=_SONARS_KEPT)
            for topic in config.sonar_topics
        ]
        self._cones: dict[str, tuple[Any, SE2, int]] = {}
        self._scan = stamped_input(node, LaserScan, "scan", SENSOR_QOS)
        self._maps = {
            "map": LiveInput(node, OccupancyGrid, "map", LATCHED_QOS),
            "glass": LiveInput(node, OccupancyGrid, "map/glass", LATCHED_QOS),
        }
        self._drawn_maps: dict[str, Any] = {}
        self._ways = {
            "path": LiveInput(node, Path, "path", LATCHED_QOS),
            "trajectory": LiveInput(node, Path, "trajectory", RELIABLE_QOS),
        }
        self._goal = LiveInput(node, PoseStamped, "goal_pose", RELIABLE_QOS)
        self._markers = LiveInput(node, MarkerArray, "planner/markers", RELIABLE_QOS)
        self._planner = LiveInput(node, DiagnosticStatus, "planner/state", RELIABLE_QOS)
        self._image = (
            LiveInput(node, Image, config.image_topic, SENSOR_QOS) if config.image_topic else None
        )
        self.set_config(config)

    @property
    def needed(self) -> list[LiveInput]:
        """What must come for there to be anything to see; the scan is the one that must go on."""
        return [self._maps["map"], self._scan]

    @property
    def inputs(self) -> list[LiveInput]:
        """All of them."""
        image = [] if self._image is None else [self._image]
        return [
            *self._maps.values(), self._scan, *self._sonars, *self._ways.values(), self._goal,
            self._markers, self._planner, *image,
        ]  # fmt: skip

    def set_config(self, config: LiveViewConfig) -> None:
        """Take other settings of pictures."""
        self._config = config
        self._pictures = Throttle(int(_NS / config.image_rate_hz))

    def open(self) -> None:
        """Listen, from nothing."""
        self._drawn_maps.clear()
        self._cones.clear()
        self.faults.clear()
        self.frames.clear()
        for each in self.inputs:
            each.open()

    def close(self) -> None:
        """Listen to nothing; goals are heard on, since nobody says them twice."""
        for each in self.inputs:
            if each is not self._goal:
                each.close()

    def news(self) -> dict[str, Message]:
        """Return what is new, by slot."""
        found: dict[str, Message] = {}
        for slot, each in self._maps.items():
            self._add(found, slot, each.topic, lambda s=slot, e=each: self._map(s, e))
        for slot, each in self._ways.items():
            self._add(found, slot, each.topic, lambda s=slot, e=each: self._way(s, e))
        self._add(found, "scan", self._scan.topic, self._scan_drawn)
        self._add(found, "sonar", "sonar", self._sonars_drawn)
        self._add(found, "goal", self._goal.topic, self._goal_drawn)
        self._add(found, "markers", self._markers.topic, self._markers_drawn)
        if (state := self._planner.take()) is not None:
            found["planner"] = draw.state_message(state)
        if self._image is not None and self._image.messages:
            self._add(found, "image", self._image.topic, self._picture)
        return found

    def _add(
        self, found: dict[str, Message], slot: str, topic: str, make: Callable[[], Message | None]
    ) -> None:
        """Add what `make` returns; what it cannot draw is named, and the node goes on."""
        try:
            made = make()
        except (ValueError, OverflowError) as error:
            self.faults[topic] = f"{topic} cannot be drawn: {error}"
            return
        if made is not None:
            self.faults.pop(topic, None)
            found[slot] = made

    def _map(self, slot: str, each: LiveInput) -> Message | None:
        if not each.messages:
            return None
        T_map_frame = self.frames.find(each.messages[-1].header.frame_id)
        if T_map_frame is None:
            return None  # it waits
        msg = each.take()
        if _is_same(msg, self._drawn_maps.get(slot)):
            return None
        self._drawn_maps[slot] = msg
        return draw.map_message(slot, msg, T_map_frame)

    def _way(self, slot: str, each: LiveInput) -> Message | None:
        if not each.messages:
            return None
        T_map_frame = self.frames.find(each.messages[-1].header.frame_id)
        return None if T_map_frame is None else draw.way_message(slot, each.take(), T_map_frame)

    def _goal_drawn(self) -> Message | None:
        if not self._goal.messages:
            return None
        T_map_frame = self.frames.find(self._goal.messages[-1].header.frame_id)
        return None if T_map_frame is None else draw.goal_message(self._goal.take(), T_map_frame)

    def _scan_drawn(self) -> Message | None:
        def find(msg: Any) -> SE2 | None:
            return self.frames.find(msg.header.frame_id, stamp_to_ns(msg.header.stamp))

        found = self._scan.take_with(find)
        return None if found is None else draw.scan_message(*found)

    def _sonars_drawn(self) -> Message | None:
        new = [(each.topic, msg) for each in self._sonars for msg in each.messages]
        for each in self._sonars:
            each.messages.clear()
        if not new:
            return None
        base, now_ns = self._node.frames.base, self._node.time.steady_ns()
        for topic, msg in new:
            frame = msg.header.frame_id
            try:
                T_base_sonar = self._node.transforms.buffer.lookup(base, frame).to_se2()
            except (TransformUnavailable, ValueError):
                continue  # the mapper says it; without its place a sonar is not drawn
            self._cones[f"{topic} {frame}"] = msg, T_base_sonar, now_ns
        oldest_ns = now_ns - int(self._config.silent_after_s * _NS)
        self._cones = {key: cone for key, cone in self._cones.items() if cone[2] >= oldest_ns}
        return draw.sonar_message([cone[:2] for cone in self._cones.values()])

    def _markers_drawn(self) -> Message | None:
        msg = self._markers.take()
        if msg is None:
            return None
        frames = {marker.header.frame_id for marker in msg.markers if marker.header.frame_id}
        places = {frame: self.frames.find(frame) for frame in frames}
        return draw.markers_message(msg, {f: T for f, T in places.items() if T is not None})

    def _picture(self) -> Message | None:
        assert self._image is not None
        if not self._pictures.is_due(self._node.time.steady_ns()):
            return None
        config = self._config
        return draw.image_message(self._image.take(), config.image_width_px, config.image_quality)


def _is_same(msg: Any, other: Any) -> bool:
    """Tell whether two maps have the same cells at the same place."""
    if other is None or (msg.info.width, msg.info.height) != (other.info.width, other.info.height):
        return False
    if (msg.info.origin, msg.header.frame_id) != (other.info.origin, other.header.frame_id):
        return False
    return np.array_equal(from_field(msg.data, np.int8), from_field(other.data, np.int8))
