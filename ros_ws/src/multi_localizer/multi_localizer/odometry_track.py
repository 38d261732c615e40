"""Poses of an odometry between its messages, and a little beyond the newest."""

from __future__ import annotations

from floornav_common.se2 import SE2
from multi_localizer.stamped_values import StampedValues


def pose_at(
    odometry: StampedValues[SE2], stamp_ns: int, gap_ns: float, beyond_ns: float
) -> SE2 | None:
    """Return the pose at a stamp; None where the odometry does not tell.

    Args:
        odometry: Poses in the odometry's frame.
        stamp_ns: Wanted, by the same clock.
        gap_ns: How far two messages may be apart for something to be known between them.
        beyond_ns: How far beyond the newest message the last motion is carried on.
    """
    before, after = odometry.around(stamp_ns)
    if before is None:
        return None
    if after is not None:
        span = after[0] - before[0]
        if span > gap_ns:
            return None
        share = (stamp_ns - before[0]) / span if span else 0.0
        return before[1].interpolate(after[1], share)
    earlier, _ = odometry.around(before[0] - 1)
    if stamp_ns - before[0] > beyond_ns or earlier is None:
        return None
    share = (stamp_ns - earlier[0]) / (before[0] - earlier[0])
    return earlier[1] @ _times(earlier[1].between(before[1]), share)


def _times(motion: SE2, share: float) -> SE2:
    return SE2(share * motion.x, share * motion.y, share * motion.yaw)
