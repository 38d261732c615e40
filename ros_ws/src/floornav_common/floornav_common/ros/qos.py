"""QoS by name, with the standard overrides, and words for an other side that does not match.

DESIGN: all we publish is reliable, depth 5; maps and paths latched; sensors are subscribed with
the sensor-data profile (REP 2003), so they match reliable and best-effort drivers alike.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription


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
    QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY,
)  # fmt: skip


def copy_qos(qos: QoSProfile) -> QoSProfile:
    """Return a profile of its own: rclpy writes overrides into the one it is given."""
    return QoSProfile(
        history=qos.history, depth=qos.depth, reliability=qos.reliability, durability=qos.durability
    )


def create_publisher(node: Node, msg_type: type, topic: str, qos: QoSProfile) -> Publisher:
    """Create a publisher that takes `qos_overrides.<topic>.publisher.*` parameters."""
    return node.create_publisher(
        msg_type, topic, copy_qos(qos), qos_overriding_options=QoSOverridingOptions(_OVERRIDABLE)
    )


def create_subscription(
    node: Node, msg_type: type, topic: str, callback: Callable[[Any], None], qos: QoSProfile
) -> Subscription:
    """Create a subscription that takes `qos_overrides.<topic>.subscription.*` parameters."""
    return node.create_subscription(
        msg_type, topic, callback, copy_qos(qos),
        qos_overriding_options=QoSOverridingOptions(_OVERRIDABLE),
    )  # fmt: skip
