"""The ROS domain of a demo: one of its own, or the user's if nobody simulates there."""

from __future__ import annotations

import os
import time
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from _processes import ChildDiedError, free_domain

_LOOK_S = 5.0  # discovery takes 0.1 s, now and then 3 s
_NAME_S = 1.0
_NAMELESS = "_NODE_NAME_UNKNOWN_"
_CURE = "unset ROS_DOMAIN_ID and the demo takes a free domain"


def join_domain() -> str:
    """Choose the domain for this process and its children.

    Returns:
        What speaks against a domain the user chose: another `/clock` is there; "" if nothing.
    """
    if not os.environ.get("ROS_DOMAIN_ID"):
        os.environ["ROS_DOMAIN_ID"] = str(free_domain())
        return ""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("demo_domain")
    try:
        end = time.monotonic() + _LOOK_S
        while time.monotonic() < end and not node.count_publishers("/clock"):
            time.sleep(0.05)
        return _found(node)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def refuse_other_clock(node: Node, num_own: int) -> None:
    """Look for a `/clock` beside this run's: one found late, or started later.

    Raises:
        ChildDiedError: There is one; two simulators would mix.
    """
    if node.count_publishers("/clock") > num_own:
        raise ChildDiedError(_found(node))


def _found(node: Node) -> str:
    # A node's name may come a moment after its publisher.
    end = time.monotonic() + _NAME_S
    while True:
        infos = node.get_publishers_info_by_topic("/clock")
        if time.monotonic() > end or all(i.node_name != _NAMELESS for i in infos):
            break
        time.sleep(0.05)
    if not infos:
        return ""
    names = ", ".join(sorted(_name(info) for info in infos))
    return (
        f"another simulation or replay is in ROS domain {os.environ['ROS_DOMAIN_ID']}: "
        f"/clock is published by {names}; {_CURE}"
    )


def _name(info: Any) -> str:
    if info.node_name == _NAMELESS:
        return "a node without a name"
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
