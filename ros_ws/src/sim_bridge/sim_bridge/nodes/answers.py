"""Hears the answers that simulated time waits for, whatever their types."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS
from floornav_common.time_watch import Throttle
from sim_bridge.config import SimBridgeConfig
from sim_bridge.pacing import Pace

_LOOK_PERIOD_S = 0.5
_PATIENCE_NS, _SAY_PERIOD_NS = 5_000_000_000, 30_000_000_000
_OF_EVERY_NODE = ("/rosout", "/parameter_events", "/diagnostics", "/tf", "/tf_static", "/clock")
_LARGE = (
    "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/PointCloud2",
    "nav_msgs/msg/OccupancyGrid", "stereo_msgs/msg/DisparityImage",
)  # fmt: skip


class Answers:
    """Feeds a `Pace` from topics, and from all that nodes publish, as they appear.

    Args:
        node: The node.
        config: The topics and the nodes.
        pace: What is fed.
        stamp_ns: Where simulated time is read.
    """

    def __init__(
        self,
        node: FloornavNode,
        config: SimBridgeConfig,
        pace: Pace,
        stamp_ns: Callable[[], int],
    ) -> None:
        """Look for publishers from now on."""
        self._node, self._pace, self._stamp_ns = node, pace, stamp_ns
        self._unknown = {topic: node.resolve_topic_name(topic) for topic in config.pace_topics}
        self._nodes = {name: _full_name(node, name) for name in config.pace_nodes}
        self._heard: set[tuple[str, str]] = set()
        self._started_ns, self._says = node.time.steady_ns(), Throttle(_SAY_PERIOD_NS)
        clock = node.time.steady_clock
        self._timer = node.create_timer(_LOOK_PERIOD_S, self._look, clock=clock)

    def _look(self) -> None:
        types = dict(self._node.get_topic_names_and_types())
        for topic, full_name in list(self._unknown.items()):
            if full_name in types and self._node.count_publishers(full_name):
                del self._unknown[topic]
                self._subscribe(topic, full_name, types[full_name][0])
        there = {(space, name) for name, space in self._node.get_node_names_and_namespaces()}
        for given, (space, name) in self._nodes.items():
            if (space, name) in there:
                self._subscribe_to_node(given, space, name)
        absent = [given for given, full_name in self._nodes.items() if full_name not in there]
        self._say_missing(absent)

    def _say_missing(self, absent: list[str]) -> None:
        """Say now and then what time does not wait for, because nobody has ever seen it."""
        now_ns = self._node.time.steady_ns()
        heard = {name for name, _ in self._heard}
        texts = [f"nobody publishes {topic}" for topic in self._unknown]
        texts += [f"there is no node {name}" for name in absent if name not in heard]
        if texts and now_ns - self._started_ns > _PATIENCE_NS and self._says.is_due(now_ns):
            text = f"time does not wait for all that it should: {', '.join(texts)}"
            self._node.get_logger().warning(text)

    def _subscribe_to_node(self, given: str, space: str, name: str) -> None:
        try:
            topics = self._node.get_publisher_names_and_types_by_node(name, space)
        except RuntimeError:  # it ended meanwhile
            return
        for topic, (type_name, *_) in topics:
            is_answer = topic not in _OF_EVERY_NODE and type_name not in _LARGE
            if is_answer and (given, topic) not in self._heard:
                self._heard.add((given, topic))
                self._subscribe(given, topic, type_name)

    def _subscribe(self, waited_for: str, topic: str, type_name: str) -> None:
        def on_message(msg: Any) -> None:
            # A stamp says which instant is answered; without one it is the present.
            header = getattr(msg, "header", None)
            now_ns = self._stamp_ns()
            stamp_ns = now_ns if header is None else stamp_to_ns(header.stamp)
            if self._pace.heard(waited_for, min(stamp_ns, now_ns)):
                self._node.get_logger().info(f"{waited_for} answers again: time waits for it")

        package, _, name = type_name.partition("/msg/")
        try:
            msg_type = getattr(import_module(f"{package}.msg"), name)
        except (ImportError, AttributeError):
            text = f"{topic} is not heard as an answer: {type_name} is not installed here"
            self._node.get_logger().warning(text)
            return
        self._node.create_subscription(msg_type, topic, on_message, SENSOR_QOS)


def _full_name(node: FloornavNode, name: str) -> tuple[str, str]:
    """Return namespace and name of a node; one without a slash is in our own namespace."""
    if "/" not in name:
        return node.get_namespace(), name
    space, _, last = name.rpartition("/")
    own = node.get_namespace().rstrip("/")
    return (space or "/") if name.startswith("/") else f"{own}/{space}", last
