"""Record topics to a rosbag2: raw subscriptions, bytes as they come, the QoS that was offered.

In: any topics. Out: a bag.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from grid_mapper.nodes.bag_qos import to_recorded
from grid_mapper.nodes.message_types import message_class, message_definition
from grid_mapper.recordings.bag_writer import BagWriter

DISCOVERY_PERIOD_S = 0.1
QUEUE_DEPTH = 1000
OWN_TOPICS = ("/rosout", "/parameter_events")


class BagRecorderNode(Node):
    """Subscribes to each wanted topic as soon as someone publishes it, and writes what comes.

    Args:
        topics: Names; empty for all.
        writer: Where the messages go.
    """

    def __init__(self, topics: Collection[str], writer: BagWriter) -> None:
        """Start to look for publishers."""
        super().__init__("bag_recorder")
        self._wanted = [self.resolve_topic_name(name) for name in topics]
        self._writer = writer
        self._recorded: dict[str, Any] = {}
        self.unknown_types: dict[str, str] = {}
        self.counts: dict[str, int] = {}
        self._timer = self.create_timer(DISCOVERY_PERIOD_S, self._discover)
        self._discover()

    @property
    def missing(self) -> list[str]:
        """Wanted topics that nobody has published so far."""
        return [t for t in self._wanted if t not in self._recorded and t not in self.unknown_types]

    def _discover(self) -> None:
        for name, types in self.get_topic_names_and_types():
            is_wanted = name in self._wanted if self._wanted else name not in OWN_TOPICS
            if not is_wanted or name in self._recorded or name in self.unknown_types:
                continue
            publishers = self.get_publishers_info_by_topic(name)
            if publishers:
                self._subscribe(name, types[0], publishers)

    def _subscribe(self, name: str, msgtype: str, publishers: list[TopicEndpointInfo]) -> None:
        found = message_class(msgtype)
        if found is None:
            self.unknown_types[name] = msgtype
            self.get_logger().warning(f"{name} is not recorded: no {msgtype} on this machine")
            return
        profiles = [to_recorded(info.qos_profile) for info in publishers]
        distinct = [p for i, p in enumerate(profiles) if p not in profiles[:i]]
        type_hash = str(publishers[0].topic_type_hash)
        self._writer.add_topic(name, msgtype, distinct, message_definition(msgtype), type_hash)
        self.counts[name] = 0

        def on_message(data: bytes, info: Any) -> None:
            stamp_ns = info["received_timestamp"] or self.get_clock().now().nanoseconds
            self._writer.write(name, stamp_ns, data)
            self.counts[name] += 1

        self._recorded[name] = self.create_subscription(
            found, name, on_message, matching_qos(publishers), raw=True
        )


def matching_qos(publishers: list[TopicEndpointInfo]) -> QoSProfile:
    """Return the strongest profile that gets messages from all publishers of a topic."""
    offered = [info.qos_profile for info in publishers]
    is_reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in offered)
    is_latched = all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in offered)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=QUEUE_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )
