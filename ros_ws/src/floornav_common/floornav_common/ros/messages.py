"""Message <-> core type, for the messages more than one package uses.

Everything `..._from_msg` reads fields only, so messages that `rosbags` reads from a bag do as well
and no ROS is needed; `..._to_msg` imports the message it fills.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.readings import OdometryReading, RangeReading
from floornav_common.ros.arrays import from_field, to_field
from floornav_common.ros.images import (
    array_to_compressed,
    array_to_image,
    compressed_to_array,
    image_to_array,
)
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

__all__ = [
    "array_to_compressed", "array_to_image", "compressed_to_array", "grid_from_msg", "grid_to_msg",
    "image_to_array", "ns_to_stamp", "odometry_from_msg", "odometry_to_msg", "pose_to_se2",
    "poses_from_msg", "poses_to_msg", "range_from_msg", "range_to_msg", "ros_cov_to_se2",
    "scan_from_msg", "scan_to_msg", "se2_cov_to_ros", "se2_to_pose", "stamp_to_ns",
    "transform_from_msg", "transform_to_msg",
]  # fmt: skip

_NS = 1_000_000_000
_MAX_TURN = 1.1 * 2.0 * np.pi  # some sensors measure a little more than once round
_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))  # x, y, yaw of (x, y, z, roll, pitch, yaw)


def stamp_to_ns(stamp: Any) -> int:
    """Return a builtin_interfaces/Time in ns."""
    return int(stamp.sec) * _NS + int(stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Any:
    """Return ns as a builtin_interfaces/Time."""
    from builtin_interfaces.msg import Time

    return Time(sec=stamp_ns // _NS, nanosec=stamp_ns % _NS)


def scan_from_msg(msg: Any) -> Scan:
    """Return a LaserScan as it was measured; `angle_max` is not trusted, the beam count is.

    Raises:
        ValueError: If it has no beams, its angles or range limits are no numbers (`range_max` may
            be infinite), its limits are swapped, or its beams go round more than once.
    """
    ranges = from_field(msg.ranges, np.float32).astype(np.float64)
    if not len(ranges):
        raise ValueError("scan must have beams, got none")
    _check_scan(msg, len(ranges))
    return Scan(
        ranges=ranges,
        angle_min=float(msg.angle_min),
        angle_increment=float(msg.angle_increment),
        range_min=float(msg.range_min),
        range_max=float(msg.range_max),
        time_increment=float(msg.time_increment),
    )


def _check_scan(msg: Any, num_beams: int) -> None:
    """Refuse a LaserScan whose angles or range limits mean nothing."""
    for name in ("angle_min", "angle_increment", "range_min"):
        if not np.isfinite(getattr(msg, name)):
            raise ValueError(f"scan {name} must be finite, got {getattr(msg, name)}")
    if np.isnan(msg.range_max):
        raise ValueError("scan range_max must be a number, got NaN")
    if msg.range_min > msg.range_max:
        raise ValueError(f"scan range_min {msg.range_min} must be <= range_max {msg.range_max}")
    if not msg.angle_increment:
        raise ValueError("scan angle_increment must not be 0: it is how wide a beam counts")
    turn = abs(float(msg.angle_increment)) * (num_beams - 1)
    if turn > _MAX_TURN:
        raise ValueError(
            f"scan must turn by at most {_MAX_TURN:.2f} rad, got {num_beams} beams "
            f"{msg.angle_increment} rad apart, {turn:.2f} rad"
        )


def scan_to_msg(scan: Scan, header: Any, *, scan_time: float = 0.0) -> Any:
    """Return a scan as a LaserScan with a header (std_msgs/Header: stamp of the first beam)."""
    from sensor_msgs.msg import LaserScan

    last = max(len(scan.ranges) - 1, 0)
    msg = LaserScan(header=header, scan_time=scan_time)
    msg.angle_min = float(scan.angle_min)
    msg.angle_max = float(scan.angle_min + last * scan.angle_increment)
    msg.angle_increment = float(scan.angle_increment)
    msg.range_min, msg.range_max = float(scan.range_min), float(scan.range_max)
    msg.time_increment = float(scan.time_increment)
    msg.ranges = to_field(scan.ranges.astype(np.float32, copy=False))
    return msg


def range_from_msg(msg: Any) -> RangeReading:
    """Return a sensor_msgs/Range."""
    return RangeReading(
        range=float(msg.range),
        field_of_view=float(msg.field_of_view),
        min_range=float(msg.min_range),
        max_range=float(msg.max_range),
    )


def range_to_msg(reading: RangeReading, stamp: Any, frame_id: str) -> Any:
    """Return a sonar reading as a sensor_msgs/Range of type ultrasound."""
    from sensor_msgs.msg import Range

    msg = Range(radiation_type=Range.ULTRASOUND)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.field_of_view, msg.range = reading.field_of_view, reading.range
    msg.min_range, msg.max_range = reading.min_range, reading.max_range
    return msg


def odometry_from_msg(msg: Any) -> OdometryReading:
    """Return the planar part of a nav_msgs/Odometry."""
    twist = msg.twist.twist
    return OdometryReading(
        T_odom_base=pose_to_se2(msg.pose.pose),
        twist=(float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)),
        pose_cov=ros_cov_to_se2(msg.pose.covariance),
        twist_cov=ros_cov_to_se2(msg.twist.covariance),
    )


def odometry_to_msg(reading: OdometryReading, stamp: Any, frame_id: str, child: str) -> Any:
    """Return odometry as a nav_msgs/Odometry of `child` in `frame_id`."""
    from nav_msgs.msg import Odometry

    msg = Odometry(child_frame_id=child)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.pose.pose = se2_to_pose(reading.T_odom_base)
    msg.pose.covariance = se2_cov_to_ros(reading.pose_cov)
    speeds = msg.twist.twist
    speeds.linear.x, speeds.linear.y, speeds.angular.z = (float(v) for v in reading.twist)
    msg.twist.covariance = se2_cov_to_ros(reading.twist_cov)
    return msg


def grid_from_msg(msg: Any) -> OccupancyMap:
    """Return a nav_msgs/OccupancyGrid; the cells are a read-only view on the message.

    Raises:
        ValueError: If the data do not have width x height cells.
    """
    width, height = int(msg.info.width), int(msg.info.height)
    cells = from_field(msg.data, np.int8)
    if len(cells) != width * height:
        raise ValueError(f"grid data must be {width} x {height} cells, got {len(cells)}")
    origin = pose_to_se2(msg.info.origin)
    return OccupancyMap(cells.reshape(height, width), float(msg.info.resolution), origin)


def grid_to_msg(grid: OccupancyMap, stamp: Any, frame_id: str) -> Any:
    """Return a map as a nav_msgs/OccupancyGrid of a stamp (builtin_interfaces/Time)."""
    from nav_msgs.msg import OccupancyGrid

    msg = OccupancyGrid(check_fields=True)  # then data is not copied
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.info.map_load_time = stamp
    msg.info.height, msg.info.width = grid.cells.shape
    msg.info.resolution = float(grid.resolution)
    msg.info.origin = se2_to_pose(grid.origin)
    msg.data = to_field(grid.cells)
    return msg


def pose_to_se2(pose: Any) -> SE2:
    """Return the planar part of a geometry_msgs/Pose; a quaternion of zeros means no turn.

    Raises:
        ValueError: If a number is not finite.
    """
    q = pose.orientation
    yaw = np.arctan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)
    return SE2(float(pose.position.x), float(pose.position.y), float(yaw))


def se2_to_pose(pose: SE2) -> Any:
    """Return a planar pose as a geometry_msgs/Pose."""
    from geometry_msgs.msg import Pose

    msg = Pose()
    msg.position.x, msg.position.y = float(pose.x), float(pose.y)
    msg.orientation.z = float(np.sin(pose.yaw / 2.0))
    msg.orientation.w = float(np.cos(pose.yaw / 2.0))
    return msg


def poses_from_msg(msg: Any) -> list[SE2]:
    """Return the planar poses of a geometry_msgs/PoseArray."""
    return [pose_to_se2(pose) for pose in msg.poses]


def poses_to_msg(poses: Sequence[SE2], stamp: Any, frame_id: str) -> Any:
    """Return planar poses as a geometry_msgs/PoseArray."""
    from geometry_msgs.msg import PoseArray

    msg = PoseArray(poses=[se2_to_pose(pose) for pose in poses])
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    return msg


def se2_cov_to_ros(cov: np.ndarray) -> np.ndarray:
    """Return a (3, 3) covariance of (x, y, yaw) as the 36 numbers of PoseWithCovariance.

    Raises:
        ValueError: If it is not (3, 3) and finite.
    """
    if cov.shape != (3, 3) or not np.isfinite(cov).all():
        raise ValueError(f"cov must be (3, 3) and finite, got {cov!r}")
    full = np.zeros((6, 6))
    full[_PLANAR] = cov
    return full.reshape(36)


def ros_cov_to_se2(covariance: Any) -> np.ndarray:
    """Return the (3, 3) part of (x, y, yaw) of the 36 numbers of PoseWithCovariance."""
    planar: np.ndarray = np.asarray(covariance, dtype=float).reshape(6, 6)[_PLANAR]
    return planar


def transform_from_msg(transform: Any) -> Transform3:
    """Return a geometry_msgs/Transform."""
    t, q = transform.translation, transform.rotation
    return Transform3.from_parts((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def transform_to_msg(transform: Transform3) -> Any:
    """Return a rigid transform as a geometry_msgs/Transform."""
    from geometry_msgs.msg import Transform

    msg = Transform()
    t, q = transform.translation.tolist(), transform.quat_xyzw.tolist()
    msg.translation.x, msg.translation.y, msg.translation.z = t
    msg.rotation.x, msg.rotation.y, msg.rotation.z, msg.rotation.w = q
    return msg
