"""Topics whose other side has another message type: DDS matches neither and says nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.node import Node

from floornav_common.ros.diagnostics import ERROR, OK, Diagnostics, Status
from floornav_common.ros.qos import full_names
from floornav_common.time_watch import Throttle

_PERIOD_NS = 2_000_000_000
_PART = "topic types"
_STAMPED = {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}


class TypeWatch:
    """Looks now and then for topics of a node that others use with another type.

    Args:
        node: The node.
        diagnostics: Where it is said, as part `topic types`, from the first case on.
    """

    def __init__(self, node: Node, diagnostics: Diagnostics) -> None:
        self._node, self._diagnostics = node, diagnostics
        self._throttle = Throttle(_PERIOD_NS)
        self._said: frozenset[str] = frozenset()

    def look(self, steady_ns: int) -> None:
        """Look, if it is time; say in the log what is new, and on diagnostics what is so."""
        if not self._throttle.is_due(steady_ns):
            return
        types = dict(self._node.get_topic_names_and_types())
        found = {text for text in self._conflicts(types) if text}
        for text in sorted(found - self._said):
            self._node.get_logger().warning(text)
        if found:
            self._diagnostics.set(_PART, Status(ERROR, "; ".join(sorted(found))))
        elif self._said:
            self._diagnostics.set(_PART, Status(OK, "all agree"))
        self._said = frozenset(found)

    def _conflicts(self, types: Mapping[str, list[str]]) -> list[str]:
        node, texts = self._node, []
        for own, ask, verb in (
            *((s, node.get_publishers_info_by_topic, "publishes") for s in node.subscriptions),
            *((p, node.get_subscriptions_info_by_topic, "takes") for p in node.publishers),
        ):
            if len(types.get(own.topic_name, ())) > 1:
                kind = type_name(own.msg_type)
                others = [info for info in ask(own.topic_name) if info.topic_type != kind]
                texts.append(conflict_text(own.topic_name, kind, others, verb))
        return texts


def type_name(msg_type: type) -> str:
    """Return the name of a message class as the graph has it, such as `std_msgs/msg/Bool`."""
    return f"{msg_type.__module__.partition('.')[0]}/msg/{msg_type.__name__}"


def conflict_text(topic: str, kind: str, others: list[Any], verb: str) -> str:
    """Return what is to be said of a topic, "" if nothing.

    Args:
        topic: Full name.
        kind: This node's type.
        others: Endpoints of another type, as the graph has them.
        verb: What the others do: `publishes` or `takes`.
    """
    if not others:
        return ""
    names = " and ".join(full_names(others)) or "a node that has not given its name"
    theirs = sorted({str(info.topic_type) for info in others})
    text = f"{topic}: no messages pass, {names} {verb} {' and '.join(theirs)}, this node {kind}"
    if {kind, *theirs} == _STAMPED:
        text += "; set enable_stamped_cmd_vel the same on both sides"
    return text
