"""Messages that only the mapper sends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Path

from floornav_common.ros.messages import ns_to_stamp, se2_cov_to_ros, se2_to_pose
from floornav_common.se2 import SE2


def pose_to_msg(pose: SE2, cov: np.ndarray, stamp: Any, frame_id: str) -> PoseWithCovarianceStamped:
    """Return a pose with the covariance of (x, y, yaw), shape (3, 3)."""
    msg = PoseWithCovarianceStamped()
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.pose.pose = se2_to_pose(pose)
    msg.pose.covariance = se2_cov_to_ros(cov)
    return msg


def path_to_msg(trajectory: Sequence[tuple[int, SE2]], stamp: Any, frame_id: str) -> Path:
    """Return a path of (stamp_ns, pose) rows."""
    msg = Path()
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    for stamp_ns, pose in trajectory:
        stamped = PoseStamped(pose=se2_to_pose(pose))
        stamped.header.stamp, stamped.header.frame_id = ns_to_stamp(stamp_ns), frame_id
        msg.poses.append(stamped)
    return msg
