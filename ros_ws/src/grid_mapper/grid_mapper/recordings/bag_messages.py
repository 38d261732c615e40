"""Deserialized messages of a bag to core types."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.recordings.events import RangeEvent
from grid_mapper.sonar_mount import level_sonar

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


def odometry_from(message: Any) -> Transform3:
    """Return the pose of an Odometry message.

    Raises:
        ValueError: If its numbers are no pose.
    """
    p, q = message.pose.pose.position, message.pose.pose.orientation
    return Transform3.from_parts((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def is_infrared(message: Any) -> bool:
    """Tell whether a Range is of an infrared ranger, which sees through glass."""
    return int(message.radiation_type) == int(message.INFRARED)


def range_event(
    stamp_ns: int, message: Any, T_base_sonar: Transform3, T_odom_base: SE2 | None
) -> RangeEvent:
    """Return the event of a Range, its value as it was sent.

    Raises:
        ValueError: If the sonar looks at the floor or the ceiling.
    """
    return RangeEvent(
        stamp_ns=stamp_ns,
        frame=str(message.header.frame_id),
        range=float(message.range),
        range_min=float(message.min_range),
        range_max=float(message.max_range),
        fov=float(message.field_of_view),
        T_base_sonar=level_sonar(T_base_sonar),
        T_odom_base=T_odom_base,
    )
