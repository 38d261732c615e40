"""Find the subscriptions that get nothing, as they ask for more than a publisher offers."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

PERIOD_S = 1.0
_NO_LIMIT_NS = 2**62
_NAMELESS = "_NODE_NAME_UNKNOWN_"


class UnfitSubscribers:
    """Compares publishers with the subscriptions in the graph; tells of each node once.

    The graph is looked at again and again: a subscription may be found late, and its node's name
    a moment after it. One still without a name at a second look is told of all the same.

    Args:
        node: Whose view of the graph is taken.
        publishers: By the topic to tell.
        tell: Takes one line.
    """

    def __init__(
        self, node: Node, publishers: Mapping[str, Any], tell: Callable[[str], None]
    ) -> None:
        self._node, self._publishers, self._tell = node, publishers, tell
        self._told: set[tuple[str, str, str]] = set()
        self._nameless: set[tuple[int, ...]] = set()
        self._looked_s = -PERIOD_S

    def look_now_and_then(self) -> None:
        """Look, unless it was done less than a period ago."""
        if time.monotonic() - self._looked_s >= PERIOD_S:
            self.look()

    def look(self) -> None:
        """Compare and tell what is new."""
        self._looked_s = time.monotonic()
        for topic, publisher in self._publishers.items():
            for info in self._node.get_subscriptions_info_by_topic(publisher.topic_name):
                policy = missing_policy(publisher.qos_profile, info.qos_profile)
                if policy and self._is_named(info):
                    self._tell_once(topic, _name(info), policy)

    def _is_named(self, info: Any) -> bool:
        gid = tuple(info.endpoint_gid)
        if info.node_name != _NAMELESS or gid in self._nameless:
            return True
        self._nameless.add(gid)
        return False

    def _tell_once(self, topic: str, name: str, policy: str) -> None:
        if (topic, name, policy) not in self._told:
            self._told.add((topic, name, policy))
            self._tell(
                f"{name} gets nothing of {topic}: it asks for {policy}, the"
                " recorded publisher did not offer that; change it with --qos FILE"
            )


def missing_policy(offered: QoSProfile, asked: QoSProfile) -> str:
    """Return the policy in which a subscription asks for more than is offered; "" if none."""
    if (
        asked.reliability == ReliabilityPolicy.RELIABLE
        and offered.reliability == ReliabilityPolicy.BEST_EFFORT
    ):
        return "reliability: reliable"
    if (
        asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and offered.durability == DurabilityPolicy.VOLATILE
    ):
        return "durability: transient_local"
    # Deadline and liveliness: rarely asked for, and the middleware has the words.
    compatibility, reason = qos_check_compatible(_without_limits(offered), _without_limits(asked))
    if compatibility != QoSCompatibility.ERROR:
        return ""
    parts = (part.strip().removeprefix("ERROR: ") for part in reason.split(";"))
    return "; ".join(part for part in parts if part)


def _without_limits(profile: QoSProfile) -> QoSProfile:
    """Return deadline and lease of a profile, no limit being 0.

    A publisher's own profile has 0 for it, one discovered in the graph the longest time there is;
    held against each other the two would not fit.
    """

    def limit(duration: Duration) -> Duration:
        return duration if duration.nanoseconds < _NO_LIMIT_NS else Duration()

    return QoSProfile(
        depth=1, liveliness=profile.liveliness, deadline=limit(profile.deadline),
        liveliness_lease_duration=limit(profile.liveliness_lease_duration),
    )  # fmt: skip


def _name(info: Any) -> str:
    if info.node_name == _NAMELESS:
        return "a subscriber without a node name"
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
