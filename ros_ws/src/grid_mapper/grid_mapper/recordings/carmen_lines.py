"""One line of a CARMEN log to one value: FLASER, ROBOTLASER1, RAWLASER1 and ODOM."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.ordering import seconds_to_ns

SICK_RANGE_MAX_M = 80.0
"""Reach of the SICK LMS 2xx; these logs write 81.83 or 81.91 where it saw nothing."""


SICK_NARROW_FOV_RAD = float(np.deg2rad(100.0))
SICK_NARROW_COUNTS = (101, 201, 401)


@dataclass(frozen=True)
class LaserLine:
    """A laser line.

    Attributes:
        stamp_ns: Time of the measurement, ns.
        scan: Ranges as logged.
        T_log_laser: First pose of the line: the laser's, or a corrected pose.
        T_odom_base: Second pose of the line: the robot's.
        has_poses: False for a line that holds none; they are the identity then.
    """

    stamp_ns: int
    scan: Scan
    T_log_laser: SE2
    T_odom_base: SE2
    has_poses: bool = True


@dataclass(frozen=True)
class OdomLine:
    """An ODOM line: the robot's pose at a time."""

    stamp_ns: int
    T_odom_base: SE2


def parse_flaser(words: list[str], range_max: float) -> LaserLine:
    """Read `FLASER n r1..rn x y theta odom_x odom_y odom_theta t host t_logger`.

    The beams fan from -90 degrees to the left; an odd count includes +90 degrees, an even one
    stops a step before it (CARMEN's 180 beams of 1 degree). The counts that only the 100 degree
    modes of the SICK LMS have fan from -50 to +50 degrees.

    Raises:
        ValueError: If the line is not of this layout.
    """
    n = int(words[1])
    if n < 1 or len(words) < n + 9:
        raise ValueError(f"FLASER with {n} beams needs {n + 9} words, got {len(words)}")
    fov = SICK_NARROW_FOV_RAD if n in SICK_NARROW_COUNTS else np.pi
    increment = fov / (n - 1 if n % 2 and n > 1 else n)
    ranges = np.array(words[2 : n + 2], dtype=np.float64)
    poses = [float(word) for word in words[n + 2 : n + 8]]
    return LaserLine(
        stamp_ns=seconds_to_ns(words[n + 8]),
        scan=Scan(ranges, -fov / 2.0, increment, 0.0, range_max),
        T_log_laser=SE2(*poses[:3]),
        T_odom_base=SE2(*poses[3:]),
    )


def parse_robotlaser(words: list[str]) -> LaserLine:
    """Read a ROBOTLASER1 line.

    Layout: `ROBOTLASER1 type start fov step range_max accuracy mode n r1..rn m e1..em
    laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side turn t host t`.

    Raises:
        ValueError: If the line is not of this layout.
    """
    scan, rest = _fan(words, 12)
    poses = [float(word) for word in rest[:6]]
    return LaserLine(
        stamp_ns=seconds_to_ns(rest[11]),
        scan=scan,
        T_log_laser=SE2(*poses[:3]),
        T_odom_base=SE2(*poses[3:]),
    )


def parse_rawlaser(words: list[str]) -> LaserLine:
    """Read a RAWLASER1 line: a ROBOTLASER1 without poses.

    Layout: `RAWLASER1 type start fov step range_max accuracy mode n r1..rn m e1..em t host t`.

    Raises:
        ValueError: If the line is not of this layout.
    """
    scan, rest = _fan(words, 1)
    unknown = SE2.identity()
    return LaserLine(seconds_to_ns(rest[0]), scan, unknown, unknown, has_poses=False)


def _fan(words: list[str], num_more: int) -> tuple[Scan, list[str]]:
    """Return the scan that ROBOTLASER1 and RAWLASER1 begin with, and the words behind it."""
    start, step, range_max = float(words[2]), float(words[4]), float(words[5])
    n = int(words[8])
    num_remissions = int(words[9 + n])
    rest = words[10 + n + num_remissions :]
    if n < 1 or len(rest) < num_more:
        raise ValueError(f"{words[0]} with {n} beams ends after {len(words)} words")
    return Scan(np.array(words[9 : 9 + n], dtype=np.float64), start, step, 0.0, range_max), rest


def parse_odom(words: list[str]) -> OdomLine:
    """Read `ODOM x y theta tv rv accel t host t_logger`.

    Raises:
        ValueError: If the line is not of this layout.
    """
    if len(words) < 8:
        raise ValueError(f"ODOM needs 8 words, got {len(words)}")
    x, y, yaw = (float(word) for word in words[1:4])
    return OdomLine(seconds_to_ns(words[7]), SE2(x, y, yaw))
