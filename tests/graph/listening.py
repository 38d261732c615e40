"""Run a node that also says whom it hears: `listening.py MODULE [--ros-args ...]`.

A publisher knows of a match before the other side does, and what it sends meanwhile is lost. So a
test waits for what the node under test says here, not for the publisher's count.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from floornav_common.ros.node import FloornavNode

LOOK_PERIOD_S = 0.05


def say_publishers(node: Node) -> None:
    """Print how many publishers each subscription of a node has found, whenever that changes."""
    said: dict[str, int] = {}

    def look() -> None:
        for subscription in node.subscriptions:
            topic, num = subscription.topic_name, subscription.get_publisher_count()
            if said.get(topic, 0) != num:
                said[topic] = num
                print(f"{topic} is heard from {num}", flush=True)

    node.create_timer(LOOK_PERIOD_S, look, clock=Clock(clock_type=ClockType.STEADY_TIME))


def say_publishers_when_ready() -> None:
    """Let every node of ours do so from the moment it is ready."""
    ready = FloornavNode.ready

    def ready_and_listening(node: FloornavNode, *args: Any) -> None:
        ready(node, *args)
        say_publishers(node)

    FloornavNode.ready = ready_and_listening  # type: ignore[method-assign]


if __name__ == "__main__":
    say_publishers_when_ready()
    sys.argv = sys.argv[1:]
    sys.exit(import_module(sys.argv[0]).main())
