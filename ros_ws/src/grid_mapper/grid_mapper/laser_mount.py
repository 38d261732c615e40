"""How a laser sits on the robot, also head down, as a pose in the plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2

MAX_TILT_RAD = 0.2


def level_scan(scan: Scan, T_base_laser: np.ndarray) -> tuple[Scan, SE2]:
    """Return a scan and its sensor's pose as seen from above.

    A laser mounted head down sweeps the other way round; its beams are turned over here.

    Args:
        scan: In the laser's frame.
        T_base_laser: Pose of the laser on the robot, shape (4, 4).

    Raises:
        ValueError: If the scan plane is tilted by more than 0.2 rad.
    """
    upright = T_base_laser[2, 2]
    tilt = np.arccos(np.clip(abs(upright), 0.0, 1.0))
    if tilt > MAX_TILT_RAD:
        raise ValueError(
            f"the laser's plane is tilted by {tilt:.2f} rad; a map in the plane needs "
            f"at most {MAX_TILT_RAD} (check the transform of its frame)"
        )
    yaw = np.arctan2(T_base_laser[1, 0], T_base_laser[0, 0])
    pose = SE2(float(T_base_laser[0, 3]), float(T_base_laser[1, 3]), float(yaw))
    if upright < 0.0:
        scan = replace(
            scan, angle_min=-scan.angle_min, angle_increment=-scan.angle_increment
        )  # fmt: skip
    return scan, pose
