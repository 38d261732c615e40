"""The subscription that holds a stamped message until its transform is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.qos import QoSProfile

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import create_subscription
from floornav_common.time_watch import Throttle
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import TransformUnavailable
from floornav_common.waiting_queue import Waiting, WaitingQueue

if TYPE_CHECKING:
    from floornav_common.ros.node import FloornavNode

_CAPACITY = 100  # 40 Hz for 2.5 s
_LOOK_PERIOD_S = 0.05
_WARN_PERIOD_NS = 5_000_000_000


class TransformedSubscription:
    """Calls back with `(msg, T_target_sensor)`, in stamp order, once TF covers the stamp.

    Nothing blocks: a message waits in a bounded queue, each arriving transform has a look at the
    head, and what has waited for `transform_timeout_s` is dropped, counted and named.

    Args:
        node: Node with `transforms`, `frames`, `time` and `diagnostics`.
        msg_type: Message class with a header.
        topic: Relative name.
        qos: Profile.
        target_frame: Frame to bring the data to.
        callback: Called with the message and a `Transform3`.
    """

    def __init__(
        self,
        node: FloornavNode,
        msg_type: type,
        topic: str,
        qos: QoSProfile,
        target_frame: str,
        callback: Callable[[Any, Transform3], None],
    ) -> None:
        """Subscribe, to the transforms too."""
        self.target_frame = target_frame
        self.num_received = self.num_delivered = self.num_dropped = 0
        self._node = node
        self._callback = callback
        self._queue = WaitingQueue(_CAPACITY)
        self._warnings = Throttle(_WARN_PERIOD_NS)
        self._found: Transform3 | None = None
        self._error = ""
        node.transforms.on_update(self._deliver)
        node.time.on_restart(self._restart)
        self._subscription = create_subscription(node, msg_type, topic, self._on_message, qos)
        self.topic = self._subscription.topic_name
        self._timer = node.create_timer(_LOOK_PERIOD_S, self._look, clock=node.time.steady_clock)

    def __len__(self) -> int:
        """Return how many messages wait."""
        return len(self._queue)

    def _on_message(self, msg: Any) -> None:
        self.num_received += 1
        stamp_ns = stamp_to_ns(msg.header.stamp)
        pushed_out = self._queue.push(stamp_ns, self._node.time.read_ns(), msg)
        self._drop(pushed_out, f"more than {_CAPACITY} messages wait")
        self._deliver()

    def _look(self) -> None:
        if len(self._queue):
            self._drop_late()
            self._deliver()

    def _deliver(self) -> None:
        while (waiting := self._queue.pop_head(self._is_covered)) is not None:
            assert self._found is not None
            self.num_delivered += 1
            self._callback(waiting.msg, self._found)

    def _drop_late(self) -> None:
        timeout_s = self._node.frames.transform_timeout_s
        late = self._queue.pop_late(self._node.time.read_ns(), int(timeout_s * 1e9))
        for waiting in late:
            # What waited behind an older message may well have its transform.
            if self._is_covered(waiting) and self._found is not None:
                self.num_delivered += 1
                self._callback(waiting.msg, self._found)
            else:
                self._drop([waiting], self._error)

    def _drop(self, dropped: list[Waiting], reason: str) -> None:
        self.num_dropped += len(dropped)
        if dropped and self._warnings.is_due(self._node.time.steady_ns()):
            self._node.get_logger().warning(
                f"{self.topic}: {self.num_dropped} of {self.num_received} dropped: {reason}"
            )

    def _is_covered(self, waiting: Waiting) -> bool:
        frame = waiting.msg.header.frame_id
        try:
            buffer = self._node.transforms.buffer
            self._found = buffer.lookup(self.target_frame, frame, waiting.stamp_ns)
        except (TransformUnavailable, ValueError) as error:
            self._error = str(error)
            return False
        return True

    def _restart(self) -> None:
        self._queue.clear()
