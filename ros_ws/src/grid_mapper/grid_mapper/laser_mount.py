"""A scan as the mapper takes it, live and offline: cleaned, and seen from above.

A laser mounted head down sweeps the other way round; its beams are turned over here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.scan_cleaning import clean_scan

MAX_TILT_RAD = 0.2


def level_scan(scan: Scan, T_base_laser: Transform3) -> tuple[Scan, SE2]:
    """Return the cleaned scan and its sensor's pose in the plane.

    Args:
        scan: As received, in the laser's frame.
        T_base_laser: Pose of the laser on the robot.

    Raises:
        ValueError: If the scan plane is tilted by more than 0.2 rad.
    """
    upright = np.clip(abs(T_base_laser.matrix()[2, 2]), 0.0, 1.0)
    tilt = float(np.arccos(upright))
    if tilt > MAX_TILT_RAD:
        raise ValueError(
            f"the laser's plane is tilted by {tilt:.2f} rad, a map in the plane allows "
            f"{MAX_TILT_RAD}: check the transform of its frame"
        )
    scan = clean_scan(scan)
    if T_base_laser.is_upside_down:
        scan = replace(scan, angle_min=-scan.angle_min, angle_increment=-scan.angle_increment)
    return scan, T_base_laser.to_se2()
