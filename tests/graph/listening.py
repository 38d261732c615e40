"""Run a node that also says whom it hears and reaches: `listening.py MODULE [--ros-args ...]`.

A publisher knows of a match before the other side does, and what it sends meanwhile is lost. So a
test waits for what the node under test says here, not for the publisher's count. And what the node
sends once reaches a test only if the node has found it: a subscription knows of a match earlier.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from floornav_common.ros.node import FloornavNode

LOOK_PERIOD_S = 0.05


def say_others(node: Node) -> None:
    """Print how many other sides a node's subscriptions, publishers and services have found."""
    said: dict[str, int] = {}

    def say(what: str, num: int) -> None:
        if said.get(what, 0) != num:
            said[what] = num
            print(f"{what} {num}", flush=True)

    def look() -> None:
        for subscription in node.subscriptions:
            num = subscription.get_publisher_count()
            say(f"{subscription.topic_name} is heard from", num)
        for publisher in node.publishers:
            say(f"{publisher.topic_name} is sent to", publisher.get_subscription_count())
        for service in node.services:
            name = service.service_name
            say(f"{name} is called by", node.count_clients(name))

    node.create_timer(LOOK_PERIOD_S, look, clock=Clock(clock_type=ClockType.STEADY_TIME))


def say_others_when_ready() -> None:
    """Let every node of ours do so from the moment it is ready."""
    ready = FloornavNode.ready

    def ready_and_listening(node: FloornavNode, *args: Any) -> None:
        ready(node, *args)
        say_others(node)

    FloornavNode.ready = ready_and_listening  # type: ignore[method-assign]


if __name__ == "__main__":
    say_others_when_ready()
    sys.argv = sys.argv[1:]
    sys.exit(import_module(sys.argv[0]).main())
