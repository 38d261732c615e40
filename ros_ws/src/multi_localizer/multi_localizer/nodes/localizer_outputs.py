"""What a localizer of one robot sends: its pose, and map->odom where it is to."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from floornav_common.ros.map_to_odom import MapToOdom
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.ros_conversions import estimate_to_msg


class LocalizerOutputs:
    """Publishes estimates on a topic, with the stamps of what they were made from.

    Args:
        node: The node.
        topic: Relative name.
        publish_tf: Whether map->odom is sent too.
    """

    def __init__(self, node: FloornavNode, topic: str, publish_tf: bool) -> None:
        """Make the publisher."""
        self._frame = node.frames.map
        self._publisher = create_publisher(node, PoseWithCovarianceStamped, topic, RELIABLE_QOS)
        self._tf = MapToOdom(node) if publish_tf else None
        self.num_sent = 0

    def send(self, stamp: Any, estimate: PoseEstimate, T_odom_base: SE2 | None) -> None:
        """Publish an estimate."""
        self.num_sent += 1
        self._publisher.publish(estimate_to_msg(estimate, stamp, self._frame))
        if self._tf is not None and T_odom_base is not None:
            self._tf.set(estimate.pose @ T_odom_base.inverse())

    def stop_tf(self) -> None:
        """Send map->odom no more until the next estimate."""
        if self._tf is not None:
            self._tf.set(None)
