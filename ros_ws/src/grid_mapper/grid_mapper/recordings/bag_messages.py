"""Deserialized messages of a bag to core types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.laser_mount import level_scan
from grid_mapper.recordings.events import RangeEvent, RecordingError, ScanEvent
from grid_mapper.scan_cleaning import clean_scan

StampedTransform = tuple[str, str, int, tuple[float, ...], tuple[float, ...]]


def stamp_ns_of(message: Any) -> int:
    """Return the header's stamp, ns."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def transforms_from(message: Any) -> Iterator[StampedTransform]:
    """Yield (parent, child, stamp_ns, translation, quaternion xyzw) of a TFMessage."""
    for stamped in message.transforms:
        t, q = stamped.transform.translation, stamped.transform.rotation
        yield (
            stamped.header.frame_id,
            stamped.child_frame_id,
            stamp_ns_of(stamped),
            (t.x, t.y, t.z),
            (q.x, q.y, q.z, q.w),
        )


def odometry_from(message: Any) -> tuple[int, SE2]:
    """Return stamp (ns) and planar pose of an Odometry message."""
    p, q = message.pose.pose.position, message.pose.pose.orientation
    pose = Transform3.from_parts((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    return stamp_ns_of(message), pose.to_se2()


def scan_event(
    message: Any, T_base_laser: Transform3, T_odom_base: SE2 | None, follows_jump: bool
) -> ScanEvent:
    """Return the event of a LaserScan.

    Raises:
        RecordingError: If the laser does not sweep in the plane.
    """
    scan = Scan(
        ranges=np.asarray(message.ranges, dtype=np.float64),
        angle_min=float(message.angle_min),
        angle_increment=float(message.angle_increment),
        range_min=float(message.range_min),
        range_max=float(message.range_max),
        time_increment=float(message.time_increment),
    )
    try:
        leveled, pose = level_scan(scan, T_base_laser)
    except ValueError as error:
        raise RecordingError(f"{message.header.frame_id}: {error}") from error
    return ScanEvent(stamp_ns_of(message), leveled, pose, T_odom_base, follows_jump)


def range_event(message: Any, T_base_sonar: Transform3, T_odom_base: SE2 | None) -> RangeEvent:
    """Return the event of a Range; its value is cleaned as a scan of one beam is."""
    reach = Scan(
        np.array([message.range], dtype=np.float64), 0.0, 0.0,
        float(message.min_range), float(message.max_range),
    )  # fmt: skip
    value = float(clean_scan(replace(reach)).ranges[0])
    return RangeEvent(
        stamp_ns=stamp_ns_of(message),
        frame=str(message.header.frame_id),
        range=value,
        range_min=reach.range_min,
        range_max=reach.range_max,
        fov=float(message.field_of_view),
        T_base_sonar=T_base_sonar.to_se2(),
        T_odom_base=T_odom_base,
    )
