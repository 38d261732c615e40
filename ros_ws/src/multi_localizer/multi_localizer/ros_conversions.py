"""Messages that only localizers read and send."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped

from floornav_common.ros.messages import pose_to_se2, ros_cov_to_se2, se2_cov_to_ros, se2_to_pose
from multi_localizer.pose_estimate import PoseEstimate


def estimate_to_msg(estimate: PoseEstimate, stamp: Any, frame_id: str) -> PoseWithCovarianceStamped:
    """Return an estimate as a message with a stamp (builtin_interfaces/Time)."""
    msg = PoseWithCovarianceStamped()
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.pose.pose = se2_to_pose(estimate.pose)
    msg.pose.covariance = se2_cov_to_ros(estimate.cov)
    return msg


def estimate_from_msg(msg: Any) -> PoseEstimate:
    """Return a PoseWithCovarianceStamped as an estimate.

    Raises:
        ValueError: If a number is not finite, or the covariance of x, y, yaw is not positive
            definite (all zeros mean that nobody knows it).
    """
    return PoseEstimate(pose_to_se2(msg.pose.pose), ros_cov_to_se2(msg.pose.covariance))


def bearings_from_msg(msg: Any) -> np.ndarray:
    """Return the bearings of a PoseArray, shape (m,), rad; NaN where an orientation is no number.

    Zeros as a quaternion name no direction: they give NaN too.
    """
    quaternions = [
        (p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w) for p in msg.poses
    ]
    x, y, z, w = np.array(quaternions, dtype=float).reshape(-1, 4).T
    yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    is_void = ~np.isfinite(x + y + z + w) | (x * x + y * y + z * z + w * w == 0.0)
    bearings: np.ndarray = np.where(is_void, np.nan, yaw)
    return bearings
