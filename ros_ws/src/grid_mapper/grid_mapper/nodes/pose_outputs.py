"""The poses that the mapping node publishes: the newest, and the way so far."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Path

from floornav_common.ros import messages
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2
from grid_mapper.path_thinner import PathThinner
from grid_mapper.ros_conversions import path_to_msg, pose_to_msg, stamped_pose


class PoseOutputs:
    """Publishes `pose` and `trajectory` in the map frame."""

    def __init__(self, node: FloornavNode) -> None:
        """Make the publishers."""
        self._frame = node.frames.map
        self._pose_pub = create_publisher(node, PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
        self._path_pub = create_publisher(node, Path, "trajectory", RELIABLE_QOS)
        self.forget()

    def forget(self) -> None:
        """Begin a new way."""
        self._path: PathThinner[Any] = PathThinner(
            lambda stamp_ns, pose: stamped_pose(stamp_ns, pose, self._frame)
        )

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest pose; None before the first."""
        return self._path.newest_stamp_ns

    def publish_pose(self, stamp: Any, pose: SE2, cov: np.ndarray) -> None:
        """Publish a pose with its covariance, shape (3, 3), and add it to the way."""
        self._path.add(messages.stamp_to_ns(stamp), pose)
        self._pose_pub.publish(pose_to_msg(pose, cov, stamp, self._frame))

    def publish_path(self, stamp: Any) -> None:
        """Publish the way so far."""
        self._path_pub.publish(path_to_msg(self._path.rows(), stamp, self._frame))
