"""Play serialized messages as they were recorded.

In: nothing. Out: the topics of a bag, `/clock` in recorded time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from floornav_common.ros.qos import CLOCK_QOS
from grid_mapper.nodes.bag_qos import overridden, to_offered
from grid_mapper.nodes.message_types import message_class
from grid_mapper.nodes.unfit_subscribers import UnfitSubscribers
from grid_mapper.recordings.bag import Message, Topic
from grid_mapper.recordings.playback import STATIC_NAME, offered_profile

CLOCK_TOPIC = "/clock"
NS_PER_S = 1_000_000_000
LAST_S = 0.3
ACK_TIMEOUT_S = 2


class BagPlayerNode(Node):
    """Has a publisher for each topic of a bag whose type is installed.

    Args:
        topics: Those to play.
        remap: Recorded name to name to publish.
        overrides: QoS policies by recorded name, which beat what was recorded.
        has_clock: Whether `/clock` is published.
    """

    def __init__(
        self,
        topics: list[Topic],
        remap: Mapping[str, str],
        overrides: Mapping[str, dict[str, Any]],
        has_clock: bool,
    ) -> None:
        """Make the publishers."""
        super().__init__("bag_player")
        self.unknown_types: dict[str, str] = {}
        self._publishers_by_topic: dict[str, Any] = {}
        for topic in topics:
            found = message_class(topic.msgtype)
            if found is None:
                self.unknown_types[topic.name] = topic.msgtype
                continue
            profile = to_offered(offered_profile(topic), topic.name.endswith(STATIC_NAME))
            profile = overridden(profile, overrides.get(topic.name, {}), topic.name)
            name = remap.get(topic.name, topic.name)
            self._publishers_by_topic[topic.name] = self.create_publisher(found, name, profile)
        self._clock_pub = (
            self.create_publisher(Clock, CLOCK_TOPIC, CLOCK_QOS) if has_clock else None
        )

    @property
    def playable(self) -> list[str]:
        """Recorded names of the topics that can be played."""
        return list(self._publishers_by_topic)

    @property
    def num_heard(self) -> int:
        """How many topics have a subscriber."""
        return sum(p.get_subscription_count() > 0 for p in self._publishers_by_topic.values())

    def watch_unfit(self, tell: Callable[[str], None]) -> UnfitSubscribers:
        """Return what finds the subscriptions that ask for more than is offered."""
        return UnfitSubscribers(self, self._publishers_by_topic, tell)

    def play(self, message: Message) -> None:
        """Publish a message's bytes."""
        self._publishers_by_topic[message.topic].publish(message.data)

    def tick(self, now_ns: int) -> None:
        """Publish the time."""
        if self._clock_pub is not None:
            sec, nanosec = divmod(now_ns, NS_PER_S)
            self._clock_pub.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))

    def wait_for_delivery(self) -> None:
        """Give reliable subscribers time to get the last messages."""
        for publisher in self._publishers_by_topic.values():
            publisher.wait_for_all_acked(Duration(seconds=ACK_TIMEOUT_S))
        time.sleep(LAST_S)  # nobody acknowledges best-effort messages: leave them time to arrive
