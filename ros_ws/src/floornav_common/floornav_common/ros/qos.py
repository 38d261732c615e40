"""QoS by name, with the standard overrides, and words for an other side that does not match.

DESIGN: all we publish is reliable, depth 5; maps and paths latched; sensors are subscribed with
the sensor-data profile (REP 2003), so they match reliable and best-effort drivers alike.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_policy_name_from_kind,
)
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from floornav_common.ros.parameters import ParameterError
from floornav_common.time_watch import Throttle


def _profile(depth: int, reliability: ReliabilityPolicy, *, is_latched: bool = False) -> QoSProfile:
    durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=reliability, durability=durability
    )


SENSOR_QOS = _profile(5, ReliabilityPolicy.BEST_EFFORT)
RELIABLE_QOS = _profile(5, ReliabilityPolicy.RELIABLE)
LATCHED_QOS = _profile(1, ReliabilityPolicy.RELIABLE, is_latched=True)
CLOCK_QOS = _profile(1, ReliabilityPolicy.BEST_EFFORT)
TF_QOS = _profile(100, ReliabilityPolicy.RELIABLE)
TF_STATIC_QOS = _profile(100, ReliabilityPolicy.RELIABLE, is_latched=True)

_OVERRIDABLE = (
    QoSPolicyKind.HISTORY,
    QoSPolicyKind.DEPTH,
    QoSPolicyKind.RELIABILITY,
    QoSPolicyKind.DURABILITY,
)
_LOSS_PERIOD_NS = 10_000_000_000
_NAME_LOOK_S, _NAME_LOOKS = 0.1, 20
_WEAKEST = {"RELIABILITY": "best_effort", "DURABILITY": "volatile"}
_STRONGEST = {"RELIABILITY": "reliable", "DURABILITY": "transient_local"}


def copy_qos(qos: QoSProfile) -> QoSProfile:
    """Return a profile of its own: rclpy writes overrides into the one it is given."""
    return QoSProfile(
        history=qos.history, depth=qos.depth, reliability=qos.reliability, durability=qos.durability
    )


def create_publisher(node: Node, msg_type: type, topic: str, qos: QoSProfile) -> Publisher:
    """Create a publisher that takes `qos_overrides.<topic>.publisher.*` parameters.

    A subscriber that asks for more than is offered is named in a warning, with the cure.

    Raises:
        ParameterError: If an override is none of the policy's values.
    """
    own = copy_qos(qos)

    def mismatched() -> list[Any]:
        infos = node.get_subscriptions_info_by_topic(publisher.topic_name)
        return [i for i in infos if not _is_compatible(own, i.qos_profile)]

    def warn(event: Any) -> None:
        _warn_when_named(node, publisher.topic_name, event, mismatched, "publisher")

    publisher: Publisher = _with_overrides(
        node.create_publisher, msg_type, topic, own,
        event_callbacks=PublisherEventCallbacks(incompatible_qos=warn),
    )  # fmt: skip
    return publisher


def create_subscription(
    node: Node, msg_type: type, topic: str, callback: Callable[[Any], None], qos: QoSProfile
) -> Subscription:
    """Create a subscription that takes `qos_overrides.<topic>.subscription.*` parameters.

    A publisher that offers less than is asked for is named in a warning, with the cure.

    Raises:
        ParameterError: If an override is none of the policy's values.
    """
    own = copy_qos(qos)

    def mismatched() -> list[Any]:
        infos = node.get_publishers_info_by_topic(subscription.topic_name)
        return [i for i in infos if not _is_compatible(i.qos_profile, own)]

    def warn(event: Any) -> None:
        _warn_when_named(node, subscription.topic_name, event, mismatched, "subscription")

    def warn_of_loss(event: Any) -> None:
        if losses.is_due(time.monotonic_ns()):
            name = subscription.topic_name
            text = lost_text(name, event.total_count, publisher_names(node, name))
            node.get_logger().warning(text)

    losses = Throttle(_LOSS_PERIOD_NS)
    callbacks = SubscriptionEventCallbacks(incompatible_qos=warn, message_lost=warn_of_loss)
    subscription: Subscription = _with_overrides(
        node.create_subscription, msg_type, topic, callback, own, event_callbacks=callbacks
    )
    return subscription


def mismatch_text(topic: str, policy: str, others: list[str], role: str) -> str:
    """Return the warning about an incompatible other side.

    Args:
        topic: Full topic name.
        policy: Name of the policy that does not match, such as `RELIABILITY`.
        others: Full names of the nodes on the other side.
        role: What we are: `publisher` or `subscription`.
    """
    names = " and ".join(others) or "a node that has not given its name"
    key = f"qos_overrides.{topic}.{role}.{policy.lower()}"
    if role == "subscription":
        what, cure = "publishes with less", _WEAKEST.get(policy)
    else:
        what, cure = "asks for more", _STRONGEST.get(policy)
    text = f"{topic}: no messages pass, {names} {what} {policy.lower()} than this node"
    return f"{text}; start this node with -p {key}:={cure}" if cure else text


def lost_text(topic: str, num_lost: int, others: list[str]) -> str:
    """Return the warning about messages that a matching publisher sent but that did not arrive."""
    names = " and ".join(others) or "its publisher"
    key = f"qos_overrides.{topic}.subscription.reliability"
    return (
        f"{topic}: messages from {names} get lost, {num_lost} so far; start both with the Fast DDS "
        f"profile (FASTRTPS_DEFAULT_PROFILES_FILE), or this node with -p {key}:=reliable"
    )


def publisher_names(node: Node, topic: str) -> list[str]:
    """Return the full names of the nodes that publish a topic (full name), this one left out."""
    own = node.get_fully_qualified_name()
    return [name for name in full_names(node.get_publishers_info_by_topic(topic)) if name != own]


def _with_overrides(create: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    options = QoSOverridingOptions(_OVERRIDABLE)
    try:
        return create(*args, qos_overriding_options=options, **kwargs)
    except RuntimeError as error:
        if "QoS override" not in str(error):
            raise
        raise ParameterError(f"{args[1]}: {error}") from error


def _warn_when_named(
    node: Node, topic: str, event: Any, mismatched: Callable[[], list[Any]], role: str
) -> None:
    """Warn once the other side's name is known: the graph hears it a moment after the event."""
    policy = qos_policy_name_from_kind(event.last_policy_kind)
    num_looks = 0

    def look() -> None:
        nonlocal num_looks
        num_looks += 1
        names = full_names(mismatched())
        if names or num_looks >= _NAME_LOOKS:
            node.destroy_timer(timer)
            node.get_logger().warning(mismatch_text(topic, policy, names, role))

    timer = node.create_timer(_NAME_LOOK_S, look, clock=Clock(clock_type=ClockType.STEADY_TIME))


def _is_compatible(publisher: QoSProfile, subscription: QoSProfile) -> bool:
    compatibility, _ = qos_check_compatible(publisher, subscription)
    return bool(compatibility != QoSCompatibility.ERROR)


def full_names(infos: list[Any]) -> list[str]:
    """Return full node names; those the graph has not heard yet are left out."""
    names = {f"{i.node_namespace.rstrip('/')}/{i.node_name}" for i in infos}
    return sorted(name for name in names if "_UNKNOWN_" not in name)
