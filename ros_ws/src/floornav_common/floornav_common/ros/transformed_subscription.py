"""The subscription that holds a stamped message until its transform is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.qos import QoSProfile

from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import create_subscription
from floornav_common.time_watch import Throttle
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import TransformUnavailable
from floornav_common.waiting_queue import StampOrder, Waiting, WaitingQueue

if TYPE_CHECKING:
    from floornav_common.ros.node import FloornavNode

CAPACITY = 100  # 2.5 s at 40 Hz
_WARN_PERIOD_NS = 5_000_000_000
_BEHIND_IN_A_ROW = 20  # one is late; a second or two of nothing else is a stamp that jumped back
_BEHIND = "a message came late, older than one already handed over"
_UNSTAMPED = "a message has stamp 0, which no transform belongs to: its driver must stamp it"


class TransformedSubscription:
    """Calls back with `(msg, T_target_sensor)`, in stamp order, once TF covers the stamp.

    Nothing blocks: a message waits in a bounded queue, each arriving transform has a look at the
    head, and what has waited for `transform_timeout_s` is dropped, counted and named.

    A message that comes late is put in its place while newer ones still wait; once a newer one was
    handed over it is dropped and counted, so stamps of one frame never run back in the callback;
    sensors that share a topic do not hold each other up by their clocks. Only a clock or transforms
    that jump back, or 20 such messages in a row, begin a new order.

    Stamp 0 would be looked up as "the newest transform": such a message is dropped and named.

    Args:
        node: Node with `transforms`, `frames`, `time` and `diagnostics`.
        msg_type: Message class with a header.
        topic: Relative name.
        qos: Profile.
        target_frame: Frame to bring the data to.
        callback: Called with the message and a `Transform3`.
        sensor_frame: Frame of the data, full name, where it is not the header's: a mask of the
            floor is in the camera's frame, what it shows in that of the floor.

    Attributes:
        topic: Full name of the topic.
        num_received: Messages that came.
        num_delivered: Messages handed to the callback.
        num_dropped: Messages given up, for want of a transform, of room or of a stamp, or for
            coming too late.
        num_behind: Those of them that came after a newer one of their frame was handed over.
    """

    def __init__(
        self,
        node: FloornavNode,
        msg_type: type,
        topic: str,
        qos: QoSProfile,
        target_frame: str,
        callback: Callable[[Any, Transform3], None],
        sensor_frame: str = "",
    ) -> None:
        """Subscribe, to the transforms too."""
        self._sensor_frame = sensor_frame
        self.target_frame = target_frame
        self.num_received = self.num_delivered = self.num_dropped = self.num_behind = 0
        self._node = node
        self._callback = callback
        self._queue = WaitingQueue(CAPACITY)
        self._warnings = Throttle(_WARN_PERIOD_NS)
        self._orders: dict[str, StampOrder] = {}
        self._problem = self._error = ""
        self._dropped_at_ns: int | None = None
        node.transforms.on_update(self._deliver)
        node.transforms.on_restart(self._orders.clear)
        node.time.on_restart(self._restart)
        node.time.on_look(self._look)
        self._subscription = create_subscription(node, msg_type, topic, self._on_message, qos)
        self.topic = self._subscription.topic_name
        node.diagnostics.add(f"transforms of {self.topic}", self.status)

    def status(self) -> Status:
        """Return whether the messages of the last seconds found their transforms."""
        values = {
            "received": self.num_received,
            "delivered": self.num_delivered,
            "dropped": self.num_dropped,
            "dropped, too old": self.num_behind,
            "waiting": len(self._queue),
            "last reason": self._error,
        }
        since_ns = self._node.time.steady_ns() - (self._dropped_at_ns or 0)
        if self._dropped_at_ns is not None and since_ns < _WARN_PERIOD_NS:
            return Status(WARN, self._problem, values)
        return Status(OK, "transforms are there" if self.num_delivered else "no message", values)

    def _on_message(self, msg: Any) -> None:
        self.num_received += 1
        stamp_ns = stamp_to_ns(msg.header.stamp)
        if stamp_ns == 0:
            self._drop(_UNSTAMPED)
            return
        for waiting in self._queue.push(stamp_ns, self._node.time.read_ns(), msg):
            self._drop_untransformed(waiting, f"more than {CAPACITY} messages wait")
        self._deliver()

    def _look(self) -> None:
        timeout_ns = int(self._node.frames.transform_timeout_s * 1e9)
        for waiting in self._queue.pop_late(self._node.time.now_ns, timeout_ns):
            # What waited behind an older message may well have its transform.
            transform = self._find(waiting)
            if transform is not None:
                self._hand_over(waiting, transform)
            else:
                self._drop_untransformed(waiting, self._error)
        self._deliver()

    def _deliver(self) -> None:
        while (head := self._queue.head) is not None:
            transform = self._find(head)
            if transform is None:
                return
            self._queue.pop_head()
            self._hand_over(head, transform)

    def _hand_over(self, waiting: Waiting, transform: Transform3) -> None:
        frame = waiting.msg.header.frame_id
        order = self._orders.setdefault(frame, StampOrder(_BEHIND_IN_A_ROW))
        if not order.is_next(waiting.stamp_ns):
            self.num_behind += 1
            self._drop(_BEHIND)
            return
        self.num_delivered += 1
        self._callback(waiting.msg, transform)

    def _drop_untransformed(self, waiting: Waiting, reason: str) -> None:
        self._error = reason
        frame = self._frame(waiting.msg)
        self._drop(f"no transform from '{frame}' to '{self.target_frame}' in time", reason)

    def _drop(self, problem: str, reason: str = "") -> None:
        self.num_dropped += 1
        self._problem, self._dropped_at_ns = problem, self._node.time.steady_ns()
        if self._warnings.is_due(self._dropped_at_ns):
            self._node.get_logger().warning(
                f"{self.topic}: {self.num_dropped} of {self.num_received} messages dropped, "
                f"{problem}{reason and ': ' + reason}"
            )

    def _find(self, waiting: Waiting) -> Transform3 | None:
        buffer = self._node.transforms.buffer
        try:
            return buffer.lookup(self.target_frame, self._frame(waiting.msg), waiting.stamp_ns)
        except (TransformUnavailable, ValueError) as error:
            self._error = str(error)
            return None

    def _frame(self, msg: Any) -> str:
        return self._sensor_frame or str(msg.header.frame_id)

    def _restart(self) -> None:
        self._queue.clear()
        self._orders.clear()
