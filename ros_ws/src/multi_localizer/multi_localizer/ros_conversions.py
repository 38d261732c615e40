"""Messages that only localizers read and send."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import Image, RegionOfInterest
from stereo_msgs.msg import DisparityImage

from floornav_common.ros.arrays import from_field, to_field
from floornav_common.ros.messages import pose_to_se2, ros_cov_to_se2, se2_cov_to_ros, se2_to_pose
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_cameras import CameraModel, RectifiedPair


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


def camera_from_msg(msg: Any) -> CameraModel:
    """Return a CameraInfo as what stereo matching asks of it."""
    return CameraModel(
        (int(msg.width), int(msg.height)),
        np.array(msg.d, dtype=float),
        np.array(msg.k, dtype=float).reshape(3, 3),
        np.array(msg.r, dtype=float).reshape(3, 3),
        np.array(msg.p, dtype=float).reshape(3, 4),
    )


def disparities_to_msg(
    disparities: np.ndarray, pair: RectifiedPair, num_disparities: int, header: Any
) -> DisparityImage:
    """Return disparities as a DisparityImage; holes become -1, below `min_disparity`.

    Args:
        disparities: (H, W), float32, NaN in holes: column in the left image less that in the right.
        pair: The cameras; a disparity of the message is 0 at infinity, as its consumers want it.
        num_disparities: How many were searched.
        header: Of the left image.
    """
    height, width = disparities.shape
    values = np.where(np.isnan(disparities), -1.0, disparities - pair.center_shift_px)
    image = Image(encoding="32FC1", is_bigendian=0, height=height, width=width, step=4 * width)
    image.data, image.header = to_field(values.astype(np.float32).view(np.uint8)), header
    msg = DisparityImage(header=header, image=image, f=pair.focal_px, t=pair.baseline_m)
    msg.valid_window = RegionOfInterest(height=height, width=width)
    msg.min_disparity = max(0.0, -pair.center_shift_px)
    msg.max_disparity = num_disparities - 1.0 - pair.center_shift_px
    msg.delta_d = 1.0 / 16.0
    return msg


def disparities_from_msg(msg: DisparityImage) -> np.ndarray:
    """Return the disparities of a DisparityImage, (H, W), float32, px; NaN where there is none.

    Raises:
        ValueError: If its image is no whole one of 32FC1, little-endian.
    """
    image = msg.image
    if image.encoding != "32FC1" or image.is_bigendian:
        raise ValueError(f"disparities must be 32FC1, little-endian, got '{image.encoding}'")
    height, width, step = int(image.height), int(image.width), int(image.step)
    if step < 4 * width or len(image.data) != step * height or height * width == 0:
        raise ValueError(f"{len(image.data)} bytes are no disparities of {width} x {height}")
    rows = from_field(image.data, np.uint8).reshape(height, step)[:, : 4 * width]
    values = np.ascontiguousarray(rows).view(np.float32)
    is_known = np.isfinite(values) & (values >= msg.min_disparity)
    return np.where(is_known, values, np.float32(np.nan))
