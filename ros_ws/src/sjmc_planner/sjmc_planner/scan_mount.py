"""A scan on its robot: seen from above, with its sensor's place in the plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.transform3 import Transform3
from sjmc_planner.planning import Obstacles

MAX_TILT_RAD = 0.2


def mounted(scan: Scan, T_base_sensor: Transform3) -> Obstacles:
    """Return a scan and its sensor's pose; one that hangs head down is turned over.

    Raises:
        ValueError: If the scan plane is tilted by more than 0.2 rad.
    """
    tilt = float(np.arccos(np.clip(abs(T_base_sensor.matrix()[2, 2]), 0.0, 1.0)))
    if tilt > MAX_TILT_RAD:
        raise ValueError(
            f"the scan's plane is tilted by {tilt:.2f} rad, {MAX_TILT_RAD} is allowed: check the "
            "transform of its frame"
        )
    if T_base_sensor.is_upside_down:
        scan = replace(scan, angle_min=-scan.angle_min, angle_increment=-scan.angle_increment)
    return Obstacles(scan, T_base_sensor.to_se2())
