"""Who gets nothing of a publisher, found in the graph over real DDS."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from grid_mapper.nodes.unfit_subscribers import UnfitSubscribers, missing_policy

DEADLINE = Duration(seconds=1)


@pytest.fixture
def nodes() -> Iterator[list[Node]]:
    context = rclpy.Context()
    rclpy.init(context=context)
    made = [Node(name, context=context) for name in ("player", "listener")]
    yield made
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown(context=context)


def told_of(nodes: list[Node], offered: QoSProfile, asked: QoSProfile) -> list[str]:
    player, listener = nodes
    publisher = player.create_publisher(String, "words", offered)
    listener.create_subscription(String, "words", lambda _: None, asked)
    until = time.monotonic() + 20.0
    infos: list = []
    while time.monotonic() < until and not any(i.node_name == "listener" for i in infos):
        infos = player.get_subscriptions_info_by_topic(publisher.topic_name)
        time.sleep(0.05)
    assert any(i.node_name == "listener" for i in infos)
    lines: list[str] = []
    unfit = UnfitSubscribers(player, {"/words": publisher}, lines.append)
    unfit.look()
    unfit.look()
    return lines


@pytest.mark.parametrize("reliability", [ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT])
def test_subscriptions_without_limits_are_not_warned_of(nodes, reliability):
    asked = QoSProfile(depth=5, reliability=reliability)
    assert told_of(nodes, QoSProfile(depth=5), asked) == []


def test_a_latched_subscription_is_not_warned_of_where_that_is_offered(nodes):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    assert told_of(nodes, latched, latched) == []


def test_a_deadline_that_is_not_offered_is_told_once_in_clean_words(nodes):
    lines = told_of(nodes, QoSProfile(depth=5), QoSProfile(depth=5, deadline=DEADLINE))
    assert len(lines) == 1 and lines[0].startswith("/listener gets nothing of /words: ")
    assert "deadline" in lines[0] and "ERROR" not in lines[0] and "liveliness" not in lines[0]


def test_several_policies_are_told_in_clean_words():
    asked = QoSProfile(
        depth=5, deadline=DEADLINE, liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=DEADLINE,
    )  # fmt: skip
    told = missing_policy(QoSProfile(depth=5), asked)
    assert "deadline" in told and "liveliness" in told and "ERROR" not in told
    assert missing_policy(asked, asked) == ""
