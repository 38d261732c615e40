"""What the live view listens to: the newest of each topic, and only while somebody looks.

Some nodes make things only for subscribers (pictures, markers), and a view that nobody looks at
should cost nothing: subscriptions come and go with the browsers.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.qos import QoSProfile

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import create_subscription, publisher_names

_KEPT = 20  # stamped messages that wait for their transform: half a second at 40 Hz


class LiveInput:
    """One topic: its newest messages, and when the last one came.

    Args:
        node: The node.
        msg_type: Message class.
        topic: Relative name.
        qos: Profile.
        keep: How many of the newest messages are kept.

    Attributes:
        topic: Full name.
        messages: The newest, the oldest first; who uses them takes them out.
        num_received: Messages that came.
    """

    def __init__(
        self, node: FloornavNode, msg_type: type, topic: str, qos: QoSProfile, keep: int = 1
    ) -> None:
        """Subscribe."""
        self._node, self._type, self._qos = node, msg_type, qos
        self.topic = node.resolve_topic_name(topic)
        self._name = topic
        self.messages: deque[Any] = deque(maxlen=keep)
        self.num_received = 0
        self._heard_ns: int | None = None
        self._subscription: Any = None
        self.open()

    def open(self) -> None:
        """Listen, from nothing."""
        if self._subscription is None:
            self._subscription = create_subscription(
                self._node, self._type, self._name, self._on_message, self._qos
            )

    def close(self) -> None:
        """Listen no more, and forget what came."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
        self.messages.clear()
        self._heard_ns = None

    @property
    def age_s(self) -> float | None:
        """How long ago the last message came, steady time, s; None if none came."""
        if self._heard_ns is None:
            return None
        return (self._node.time.steady_ns() - self._heard_ns) * 1e-9

    def take(self) -> Any:
        """Return the newest message and forget all; None if there is none."""
        newest = self.messages[-1] if self.messages else None
        self.messages.clear()
        return newest

    def take_with(self, find: Callable[[Any], Any]) -> tuple[Any, Any] | None:
        """Return the newest message that `find` has an answer for, and that answer.

        Older ones are forgotten; newer ones wait for their transform.
        """
        for place in range(len(self.messages) - 1, -1, -1):
            msg = self.messages[place]
            found = find(msg)
            if found is not None:
                for _ in range(place + 1):
                    self.messages.popleft()
                return msg, found
        return None

    def missing(self, silent_after_s: float) -> str:
        """Return what is amiss with this input in words, "" if nothing is."""
        age_s = self.age_s
        if age_s is not None and age_s <= silent_after_s:
            return ""
        others = ", ".join(publisher_names(self._node, self.topic)) or "nobody"
        if age_s is None:
            return f"waiting for {self.topic}: published by {others}"
        return f"{self.topic} is silent for {age_s:.0f} s; published by {others}"

    def _on_message(self, msg: Any) -> None:
        self.num_received += 1
        self._heard_ns = self._node.time.steady_ns()
        self.messages.append(msg)


def stamped_input(node: FloornavNode, msg_type: type, topic: str, qos: QoSProfile) -> LiveInput:
    """Return an input whose messages wait for the transform of their stamp."""
    return LiveInput(node, msg_type, topic, qos, keep=_KEPT)
