"""Profiles by name, and the words for a mismatch."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy")
from rclpy.qos import DurabilityPolicy, QoSCompatibility, ReliabilityPolicy, qos_check_compatible

from floornav_common.ros import qos


def test_profiles_are_what_design_says() -> None:
    latched = (qos.LATCHED_QOS.depth, qos.LATCHED_QOS.durability, qos.LATCHED_QOS.reliability)
    assert latched == (1, DurabilityPolicy.TRANSIENT_LOCAL, ReliabilityPolicy.RELIABLE)
    assert qos.RELIABLE_QOS.depth == 5
    assert qos.RELIABLE_QOS.reliability == ReliabilityPolicy.RELIABLE
    assert qos.SENSOR_QOS.reliability == ReliabilityPolicy.BEST_EFFORT
    assert qos.CLOCK_QOS.reliability == ReliabilityPolicy.BEST_EFFORT


@pytest.mark.parametrize("offered", [qos.SENSOR_QOS, qos.RELIABLE_QOS, qos.LATCHED_QOS])
def test_sensor_subscriptions_match_every_driver(offered: object) -> None:
    compatibility, reason = qos_check_compatible(offered, qos.SENSOR_QOS)
    assert compatibility != QoSCompatibility.ERROR, reason


def test_a_copy_keeps_the_named_profile_from_being_overridden() -> None:
    copy = qos.copy_qos(qos.LATCHED_QOS)
    copy.depth = 7
    assert qos.LATCHED_QOS.depth == 1
    assert copy.durability == qos.LATCHED_QOS.durability


def test_the_warning_names_topic_policy_node_and_cure() -> None:
    text = qos.mismatch_text("/map", "DURABILITY", ["/old_server"], "subscription")
    assert "/map" in text and "/old_server publishes with less durability" in text
    assert text.endswith("-p qos_overrides./map.subscription.durability:=volatile")
    text = qos.mismatch_text("/scan", "RELIABILITY", ["/slam"], "publisher")
    assert "/slam asks for more reliability" in text
    assert text.endswith("-p qos_overrides./scan.publisher.reliability:=reliable")
    assert "has not given its name" in qos.mismatch_text("/scan", "DEADLINE", [], "publisher")


def test_lost_messages_name_who_sends_and_both_cures() -> None:
    text = qos.lost_text("/image", 12, ["/camera"])
    assert "messages from /camera get lost, 12 so far" in text
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" in text and "reliability:=reliable" in text
