"""QoS profiles between rclpy and the bag library, and the overrides of a YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

INFINITE_S = 1_000_000_000
"""Longer times (recorders write several "infinite" ones) are no limit."""
INFINITE = QosTime(9223372036, 854775807)
DEFAULT_DEPTH = 10
LATCHED_DEPTH = 100


def to_recorded(profile: QoSProfile) -> Qos:
    """Return a profile as the bag holds it."""
    return Qos(
        QosHistory(int(profile.history)),
        profile.depth,
        QosReliability(int(profile.reliability)),
        QosDurability(int(profile.durability)),
        _to_time(profile.deadline),
        _to_time(profile.lifespan),
        QosLiveliness(int(profile.liveliness)),
        _to_time(profile.liveliness_lease_duration),
        profile.avoid_ros_namespace_conventions,
    )


def to_offered(qos: Qos | None, is_static: bool) -> QoSProfile:
    """Return the profile a replay offers for what was recorded.

    DDS does not tell a recorder history and depth, so these are ours: 10, and 100 for latched
    topics. Without a record it is reliable, and latched for static transforms.
    """
    if qos is None:
        durability = DurabilityPolicy.TRANSIENT_LOCAL if is_static else DurabilityPolicy.VOLATILE
        depth = LATCHED_DEPTH if is_static else DEFAULT_DEPTH
        return QoSProfile(depth=depth, durability=durability)
    is_latched = qos.durability == QosDurability.TRANSIENT_LOCAL
    is_best_effort = qos.reliability == QosReliability.BEST_EFFORT
    profile = QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=max(qos.depth, LATCHED_DEPTH if is_latched else DEFAULT_DEPTH),
        reliability=ReliabilityPolicy.BEST_EFFORT if is_best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )
    for name in ("deadline", "lifespan"):
        limit: QosTime = getattr(qos, name)
        if 0 < limit.sec * 1_000_000_000 + limit.nsec < INFINITE_S * 1_000_000_000:
            setattr(profile, name, Duration(seconds=limit.sec, nanoseconds=limit.nsec))
    if qos.liveliness == QosLiveliness.MANUAL_BY_TOPIC:
        profile.liveliness = LivelinessPolicy.MANUAL_BY_TOPIC
    return profile


def load_overrides(path: Path) -> dict[str, dict[str, Any]]:
    """Read `topic: {reliability: ..., durability: ..., history: ..., depth: ...}`.

    Raises:
        ValueError: If the file cannot be read, or holds a policy or value that does not exist.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path} cannot be read: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise ValueError(f"{path} must hold `topic: {{reliability: ...}}`")
    for topic, policies in content.items():
        if not isinstance(policies, dict):
            raise ValueError(f"{path}: {topic} must hold policies such as `reliability: reliable`")
        overridden(QoSProfile(depth=1), policies, f"{path}: {topic}")
    return content


def overridden(profile: QoSProfile, policies: dict[str, Any], where: str) -> QoSProfile:
    """Return a profile with some policies replaced.

    Raises:
        ValueError: If a policy or its value does not exist.
    """
    kinds: dict[str, Any] = {
        "reliability": ReliabilityPolicy,
        "durability": DurabilityPolicy,
        "history": HistoryPolicy,
    }
    values: dict[str, Any] = {
        name: getattr(profile, name) for name in (*kinds, "depth", "deadline", "lifespan")
    }
    for name, value in policies.items():
        try:
            if name == "depth":
                values[name] = int(value)
            else:
                values[name] = kinds[name][str(value).upper()]
        except (KeyError, ValueError, TypeError):
            raise ValueError(
                f"{where}: {name}: {value} is no QoS policy and value"
                " (reliability, durability, history, depth)"
            ) from None
    return QoSProfile(**values)


def _to_time(duration: Duration) -> QosTime:
    if duration.nanoseconds >= INFINITE_S * 1_000_000_000 or duration.nanoseconds <= 0:
        return INFINITE
    return QosTime(*divmod(duration.nanoseconds, 1_000_000_000))
