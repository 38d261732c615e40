"""/tf and /tf_static: listening into our buffer, and sending."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from floornav_common.ros.messages import ns_to_stamp, stamp_to_ns, transform_to_msg
from floornav_common.ros.qos import (
    LATCHED_QOS,
    TF_QOS,
    TF_STATIC_QOS,
    create_publisher,
    create_subscription,
)
from floornav_common.time_watch import Throttle
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import TransformBuffer

Vector = tuple[float, ...]
NO_TF = "tf2_msgs is not installed: transforms are neither heard nor sent"
_WARN_PERIOD_NS = 5_000_000_000
_OLD_IN_A_ROW = 50  # a late sample or two is ignored; a second of nothing else is a looping bag


def tf_message_type() -> type | None:
    """Return tf2_msgs/TFMessage; None where tf2_msgs is not installed."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    message: type = TFMessage
    return message


class TransformListener:
    """Fills a buffer from /tf and /tf_static and tells who waits that something came.

    Args:
        node: Node to subscribe on; `-r /tf:=tf` works as for upstream's nodes.
        steady_ns: Where the steady clock is read, for throttled warnings.
    """

    def __init__(self, node: Node, steady_ns: Callable[[], int]) -> None:
        """Subscribe at once."""
        self.buffer = TransformBuffer()
        self._node = node
        self._steady_ns = steady_ns
        self._warnings = Throttle(_WARN_PERIOD_NS)
        # Per child frame: what this node sends itself comes back with stamps that go on.
        self._num_old: dict[str, int] = {}
        self._on_update: list[Callable[[], None]] = []
        self._on_sample: list[Callable[[Any], None]] = []
        self._on_restart: list[Callable[[], None]] = []
        message = tf_message_type()
        if message is None:
            node.get_logger().error(NO_TF)
            return
        create_subscription(node, message, "/tf", self._on_tf, TF_QOS)
        create_subscription(node, message, "/tf_static", self._on_tf_static, TF_STATIC_QOS)

    def on_update(self, callback: Callable[[], None]) -> None:
        """Call back after every message that changed the buffer."""
        self._on_update.append(callback)

    def on_sample(self, callback: Callable[[Any], None]) -> None:
        """Call back with every geometry_msgs/TransformStamped of /tf."""
        self._on_sample.append(callback)

    def on_restart(self, callback: Callable[[], None]) -> None:
        """Call back when the buffer forgets all that moves, for whatever reason."""
        self._on_restart.append(callback)

    def add(self, parent: str, child: str, stamp_ns: int, place: Vector, turn: Vector) -> None:
        """Store a moving transform that came another way than by /tf.

        Args:
            parent: Parent frame.
            child: Child frame.
            stamp_ns: Stamp.
            place: Translation x, y, z, m.
            turn: Quaternion x, y, z, w.
        """
        self._set(parent, child, stamp_ns, place, turn, is_static=False)
        for callback in self._on_update:
            callback()

    def clear(self) -> None:
        """Forget all that moves: the clock jumped back."""
        self.buffer.clear()
        self._num_old.clear()
        for callback in self._on_restart:
            callback()

    def _on_tf(self, msg: Any) -> None:
        for callback in self._on_sample:
            for stamped in msg.transforms:
                callback(stamped)
        self._store(msg, is_static=False)

    def _on_tf_static(self, msg: Any) -> None:
        self._store(msg, is_static=True)

    def _store(self, msg: Any, *, is_static: bool) -> None:
        for stamped in msg.transforms:
            self._store_one(stamped, is_static=is_static)
        for callback in self._on_update:
            callback()

    def _store_one(self, stamped: Any, *, is_static: bool) -> None:
        t, q = stamped.transform.translation, stamped.transform.rotation
        parent, child = stamped.header.frame_id, stamped.child_frame_id
        place, turn = (t.x, t.y, t.z), (q.x, q.y, q.z, q.w)
        self._set(parent, child, stamp_to_ns(stamped.header.stamp), place, turn, is_static)

    def _set(
        self, parent: str, child: str, stamp_ns: int, place: Vector, turn: Vector, is_static: bool
    ) -> None:  # fmt: skip
        try:
            is_new = self.buffer.set_transform(parent, child, stamp_ns, place, turn, is_static)
        except ValueError as error:
            self._warn(f"transform ignored: {error}")
            return
        self._num_old[child] = 0 if is_new else self._num_old.get(child, 0) + 1
        if self._num_old[child] >= _OLD_IN_A_ROW:
            self._warn("stamps on /tf jumped back without /clock (use_sim_time?): starting afresh")
            self.clear()

    def _warn(self, text: str) -> None:
        if self._warnings.is_due(self._steady_ns()):
            self._node.get_logger().warning(text)


class TransformBroadcaster:
    """Sends moving transforms on /tf.

    Args:
        node: Node to publish with.
        topic: Another topic than /tf, for a robot with a TF topic of its own.
    """

    def __init__(self, node: Node, topic: str = "/tf") -> None:
        """Create the publisher; says so once where tf2_msgs is missing."""
        self._publish = _tf_publish(node, topic, TF_QOS)

    def send(self, parent: str, child: str, stamp_ns: int, transform: Transform3) -> None:
        """Send `T_parent_child` of a stamp."""
        self.send_all([(parent, child, stamp_ns, transform)])

    def send_all(self, transforms: Sequence[tuple[str, str, int, Transform3]]) -> None:
        """Send several (parent, child, stamp_ns, transform) in one message."""
        self._publish([_stamped(*each) for each in transforms])


class StaticTransformBroadcaster:
    """Sends transforms that never change on /tf_static: all of them each time, latched.

    Args:
        node: Node to publish with.
        topic: Another topic than /tf_static, for a robot with a TF topic of its own.
    """

    def __init__(self, node: Node, topic: str = "/tf_static") -> None:
        """Create the publisher; says so once where tf2_msgs is missing."""
        self._sent: dict[str, Any] = {}
        self._publish = _tf_publish(node, topic, LATCHED_QOS)

    def send(self, parent: str, child: str, stamp_ns: int, transform: Transform3) -> None:
        """Send `T_parent_child`, together with all sent before."""
        self._sent[child] = _stamped(parent, child, stamp_ns, transform)
        self._publish(list(self._sent.values()))


def _tf_publish(node: Node, topic: str, qos: QoSProfile) -> Callable[[list[Any]], None]:
    """Return what publishes transforms in one message; nothing, said once, without tf2_msgs."""
    message = tf_message_type()
    if message is None:
        node.get_logger().error(NO_TF)
        return lambda transforms: None
    publisher = create_publisher(node, message, topic, qos)
    return lambda transforms: publisher.publish(message(transforms=transforms))


def _stamped(parent: str, child: str, stamp_ns: int, transform: Transform3) -> Any:
    from geometry_msgs.msg import TransformStamped

    msg = TransformStamped(child_frame_id=child)
    msg.header.stamp, msg.header.frame_id = ns_to_stamp(stamp_ns), parent
    msg.transform = transform_to_msg(transform)
    return msg
