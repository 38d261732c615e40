"""The topic `initialpose`: where somebody says the robot is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_subscription
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.ros_conversions import estimate_from_msg


def hear_initial_pose(
    node: FloornavNode, callback: Callable[[PoseEstimate], None], warn: Callable[[str], None]
) -> None:
    """Call back with each pose in the map frame; what is none is refused and said."""

    def take(msg: Any) -> None:
        if msg.header.frame_id.lstrip("/") != node.frames.map:
            warn(f"initialpose is in '{msg.header.frame_id}', not in '{node.frames.map}'")
            return
        try:
            callback(estimate_from_msg(msg))
        except ValueError as error:
            warn(f"initialpose refused: {error}")

    create_subscription(node, PoseWithCovarianceStamped, "initialpose", take, RELIABLE_QOS)
