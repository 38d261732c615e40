"""One line of a CARMEN log to one value: FLASER, ROBOTLASER1, ODOM and PARAM."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.ordering import seconds_to_ns

SICK_RANGE_MAX_M = 80.0
"""Reach of the SICK LMS 2xx; these logs write 81.83 or 81.91 where it saw nothing."""


@dataclass(frozen=True)
class LaserLine:
    """A FLASER or ROBOTLASER1 line.

    Attributes:
        stamp_ns: Time of the measurement, ns.
        scan: Ranges as logged.
        T_log_laser: First pose of the line: the laser's, or a corrected pose.
        T_odom_base: Second pose of the line: the robot's.
    """

    stamp_ns: int
    scan: Scan
    T_log_laser: SE2
    T_odom_base: SE2


@dataclass(frozen=True)
class OdomLine:
    """An ODOM line: the robot's pose at a time."""

    stamp_ns: int
    T_odom_base: SE2


def parse_flaser(words: list[str], range_max: float) -> LaserLine:
    """Read `FLASER n r1..rn x y theta odom_x odom_y odom_theta t host t_logger`.

    The beams fan from -90 degrees to the left; an odd count includes +90 degrees, an even one
    stops a step before it (CARMEN's 180 beams of 1 degree).

    Raises:
        ValueError: If the line is not of this layout.
    """
    n = int(words[1])
    if n < 1 or len(words) < n + 9:
        raise ValueError(f"FLASER with {n} beams needs {n + 9} words, got {len(words)}")
    increment = np.pi / (n - 1 if n % 2 and n > 1 else n)
    ranges = np.array(words[2 : n + 2], dtype=np.float64)
    poses = [float(word) for word in words[n + 2 : n + 8]]
    return LaserLine(
        stamp_ns=seconds_to_ns(words[n + 8]),
        scan=Scan(ranges, -np.pi / 2.0, increment, 0.0, range_max),
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
    start, step, range_max = float(words[2]), float(words[4]), float(words[5])
    n = int(words[8])
    num_remissions = int(words[9 + n])
    rest = words[10 + n + num_remissions :]
    if n < 1 or len(rest) < 12:
        raise ValueError(f"ROBOTLASER1 with {n} beams ends after {len(words)} words")
    poses = [float(word) for word in rest[:6]]
    return LaserLine(
        stamp_ns=seconds_to_ns(rest[11]),
        scan=Scan(np.array(words[9 : 9 + n], dtype=np.float64), start, step, 0.0, range_max),
        T_log_laser=SE2(*poses[:3]),
        T_odom_base=SE2(*poses[3:]),
    )


def parse_odom(words: list[str]) -> OdomLine:
    """Read `ODOM x y theta tv rv accel t host t_logger`.

    Raises:
        ValueError: If the line is not of this layout.
    """
    if len(words) < 8:
        raise ValueError(f"ODOM needs 8 words, got {len(words)}")
    x, y, yaw = (float(word) for word in words[1:4])
    return OdomLine(seconds_to_ns(words[7]), SE2(x, y, yaw))
