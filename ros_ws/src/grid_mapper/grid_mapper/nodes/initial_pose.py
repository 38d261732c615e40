"""The topic `initialpose`: where somebody says the robot is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped

from floornav_common.ros import messages
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_subscription
from floornav_common.se2 import SE2

OnPose = Callable[[SE2, np.ndarray], None]


class InitialPose:
    """Calls back with a pose and its covariance; what is no pose in the map frame is refused."""

    def __init__(self, node: FloornavNode, on_pose: OnPose, warn: Callable[[str], None]) -> None:
        """Subscribe."""
        self._frame, self._take, self._warn = node.frames.map, on_pose, warn
        create_subscription(
            node, PoseWithCovarianceStamped, "initialpose", self._on_pose, RELIABLE_QOS
        )

    def _on_pose(self, msg: Any) -> None:
        if msg.header.frame_id.lstrip("/") != self._frame:
            self._warn(f"initialpose is in '{msg.header.frame_id}', not in '{self._frame}'")
            return
        try:
            pose = messages.pose_to_se2(msg.pose.pose)
            self._take(pose, messages.ros_cov_to_se2(msg.pose.covariance))
        except ValueError as error:
            self._warn(f"initialpose refused: {error}")
