"""Observations of the simulation as messages, commands as velocities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from floornav_common.readings import OdometryReading
from floornav_common.ros.messages import (
    ns_to_stamp,
    odometry_to_msg,
    poses_to_msg,
    scan_to_msg,
)
from floornav_common.scan import Scan
from sim_bridge.camera_config import StereoConfig
from sim_bridge.config import LaserConfig, OdometryConfig
from sim_bridge.drive import Velocity
from sim_bridge.observations import GroundTruth
from sim_bridge.people.people import PersonTruth
from sim_bridge.wheels import OdometryState

GROUND_TRUTH_FRAME = "ground_truth"


def velocity_from_msg(msg: Any) -> Velocity:
    """Return the planar velocity of a Twist or TwistStamped."""
    twist = msg.twist if hasattr(msg, "twist") else msg
    return Velocity(float(twist.linear.x), float(twist.angular.z), float(twist.linear.y))


_LEAST_SD = 1e-4  # m, rad: a variance of 0, as at the start, makes filters divide by it


def odometry_msg(
    state: OdometryState, config: OdometryConfig, stamp_ns: int, frame: str, child: str
) -> Any:
    """Return dead reckoning as Odometry."""
    reading = OdometryReading(
        T_odom_base=state.pose,
        twist=(state.velocity.speed, state.velocity.side_speed, state.velocity.yaw_rate),
        pose_cov=state.cov + _LEAST_SD**2 * np.eye(3),
        twist_cov=np.diag([config.speed_sd, config.speed_sd, config.yaw_rate_sd]) ** 2,
    )
    return odometry_to_msg(reading, ns_to_stamp(stamp_ns), frame, child)


def ground_truth_msg(truth: GroundTruth, stamp_ns: int, child: str) -> Any:
    """Return the true pose in the world as Odometry, in a frame that TF does not have."""
    velocity = truth.velocity
    twist = (velocity.speed, velocity.side_speed, velocity.yaw_rate)
    reading = OdometryReading(T_odom_base=truth.pose, twist=twist)
    return odometry_to_msg(reading, ns_to_stamp(stamp_ns), GROUND_TRUTH_FRAME, child)


def scan_msg(scan: Scan, config: LaserConfig, stamp_ns: int, frame: str) -> Any:
    """Return a scan that ended at a stamp as LaserScan, which has that of its first beam."""
    from std_msgs.msg import Header

    first_ns = stamp_ns - round(config.sweep_s * 1e9)
    header = Header(stamp=ns_to_stamp(first_ns), frame_id=frame)
    return scan_to_msg(scan, header, scan_time=config.period_s)


def people_msg(people: Sequence[PersonTruth], stamp_ns: int) -> Any:
    """Return where people are in the world as PoseArray, in a frame that TF does not have."""
    poses = [person.pose for person in people]
    return poses_to_msg(poses, ns_to_stamp(stamp_ns), GROUND_TRUTH_FRAME)


def camera_info_msg(config: StereoConfig, baseline: float, stamp: Any, frame: str) -> Any:
    """Return the model of a rectified pinhole camera as CameraInfo.

    Args:
        config: Its image.
        baseline: Its distance from the left camera, m; 0 for the left camera itself.
        stamp: Of its image.
        frame: Optical frame of the left camera.
    """
    from sensor_msgs.msg import CameraInfo

    f, u, v = config.focal_px, (config.width_px - 1) / 2.0, (config.height_px - 1) / 2.0
    msg = CameraInfo(width=config.width_px, height=config.height_px)
    msg.header.stamp, msg.header.frame_id = stamp, frame
    msg.distortion_model, msg.d = "plumb_bob", [0.0] * 5
    msg.k = [f, 0.0, u, 0.0, f, v, 0.0, 0.0, 1.0]
    msg.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    msg.p = [f, 0.0, u, -f * baseline, 0.0, f, v, 0.0, 0.0, 0.0, 1.0, 0.0]
    return msg
