"""Messages that only the mapper sends."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Path

from floornav_common.grid import UNKNOWN, OccupancyMap
from floornav_common.ros.messages import ns_to_stamp, se2_cov_to_ros, se2_to_pose
from floornav_common.se2 import SE2


def pose_to_msg(pose: SE2, cov: np.ndarray, stamp: Any, frame_id: str) -> PoseWithCovarianceStamped:
    """Return a pose with the covariance of (x, y, yaw), shape (3, 3)."""
    msg = PoseWithCovarianceStamped()
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.pose.pose = se2_to_pose(pose)
    msg.pose.covariance = se2_cov_to_ros(cov)
    return msg


def stamped_pose(stamp_ns: int, pose: SE2, frame_id: str) -> PoseStamped:
    """Return one pose of a path."""
    msg = PoseStamped(pose=se2_to_pose(pose))
    msg.header.stamp, msg.header.frame_id = ns_to_stamp(stamp_ns), frame_id
    return msg


def path_to_msg(poses: list[PoseStamped], stamp: Any, frame_id: str) -> Path:
    """Return a path of poses made by `stamped_pose`."""
    msg = Path(poses=poses)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    return msg


def empty_map(resolution: float) -> OccupancyMap:
    """Return one unknown cell: the least that readers of a latched map accept as a map."""
    return OccupancyMap(np.full((1, 1), UNKNOWN, np.int8), resolution, SE2.identity())
