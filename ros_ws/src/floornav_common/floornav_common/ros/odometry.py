"""Odometry for robots whose driver publishes `odom` but no transform of it (DESIGN.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nav_msgs.msg import Odometry

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.transform_buffer import TransformUnavailable

if TYPE_CHECKING:
    from floornav_common.ros.node import FloornavNode


class OdometryFallback:
    """Fills the buffer with the pose of `odom` while /tf does not connect its two frames.

    Args:
        node: Node with `transforms`.
        topic: Relative name of the odometry.

    Attributes:
        is_used: Whether the newest message went into the buffer.
    """

    def __init__(self, node: FloornavNode, topic: str = "odom") -> None:
        """Subscribe."""
        self.is_used = False
        self._node = node
        self._on_tf: set[str] = set()
        node.transforms.on_sample(lambda stamped: self._on_tf.add(stamped.child_frame_id))
        self._subscription = create_subscription(node, Odometry, topic, self._on_odom, SENSOR_QOS)

    def _on_odom(self, msg: Any) -> None:
        parent, child = msg.header.frame_id, msg.child_frame_id
        self.is_used = bool(parent and child) and not self._is_on_tf(parent, child)
        if self.is_used:
            p, q = msg.pose.pose.position, msg.pose.pose.orientation
            self._node.transforms.add(
                parent, child, stamp_to_ns(msg.header.stamp), (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
            )

    def _is_on_tf(self, parent: str, child: str) -> bool:
        if child in self._on_tf or child.lstrip("/") in self._on_tf:
            return True
        try:
            self._node.transforms.buffer.lookup(parent, child, None)
        except (TransformUnavailable, ValueError):
            return False
        return not self.is_used
