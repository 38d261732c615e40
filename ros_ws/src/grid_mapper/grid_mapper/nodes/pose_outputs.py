"""The poses that the mapping node publishes: the newest, and the way so far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Path

from floornav_common.ros import messages
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.path_thinner import PathThinner
from grid_mapper.ros_conversions import path_to_msg, pose_to_msg, stamped_pose

MAX_POSES = 1000
"""More take too long to publish for a scan to wait."""


@dataclass(frozen=True)
class _WayPoint:
    """A pose of the way: its message, its pose by the front end, and the newest node then."""

    msg: PoseStamped
    local: tuple[float, float, float]
    node: int


class PoseOutputs:
    """Publishes `pose` and `trajectory` in the map frame.

    Args:
        node: The node.
        closing: Corrects the way where loops are closed; None where they are not.
    """

    def __init__(self, node: FloornavNode, closing: ClosingMapper | None) -> None:
        """Make the publishers."""
        self._frame, self._closing = node.frames.map, closing
        self._pose_pub = create_publisher(node, PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
        self._path_pub = create_publisher(node, Path, "trajectory", RELIABLE_QOS)
        self.forget()

    def forget(self) -> None:
        """Begin a new way."""
        self._path = PathThinner(self._way_point, max_poses=MAX_POSES)
        self._corrected_by = None if self._closing is None else self._closing.corrections

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
        rows = self._path.rows()
        if self._closing is not None and self._closing.corrections is not self._corrected_by:
            self._correct(rows, self._closing)
        self._path_pub.publish(path_to_msg([row.msg for row in rows], stamp, self._frame))

    def _way_point(self, stamp_ns: int, pose: SE2) -> _WayPoint:
        msg, closing = stamped_pose(stamp_ns, pose, self._frame), self._closing
        if closing is None:
            return _WayPoint(msg, (pose.x, pose.y, pose.yaw), 0)
        local = closing.in_local(pose)
        return _WayPoint(msg, (local.x, local.y, local.yaw), closing.node)

    def _correct(self, rows: list[_WayPoint], closing: ClosingMapper) -> None:
        """Move the way to where the graph has it by now."""
        self._corrected_by = corrections = closing.corrections
        nodes = np.array([row.node for row in rows], int)
        local = np.array([row.local for row in rows]).reshape(-1, 3)
        poses = corrections.as_poses(corrections.all_at(nodes, local))
        for row, pose in zip(rows, poses, strict=True):
            row.msg.pose = messages.se2_to_pose(pose)
