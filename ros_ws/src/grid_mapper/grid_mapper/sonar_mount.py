"""Which rangers are of use: where a sonar sits in the plane; what is refused, and why."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

MAX_TILT_RAD = 0.35
"""A cone of 20 degrees tilted by more no longer holds the horizontal."""


def level_sonar(T_base_sonar: Transform3) -> SE2:
    """Return the pose in the plane of a sonar, which looks along its x axis.

    Args:
        T_base_sonar: Pose of the sonar on the robot.

    Raises:
        ValueError: If it looks up or down by more than 0.35 rad.
    """
    x, y, z = T_base_sonar.matrix()[:3, 0]
    tilt = float(np.arctan2(abs(z), np.hypot(x, y)))
    if tilt > MAX_TILT_RAD:
        raise ValueError(
            f"the sonar looks up or down by {tilt:.2f} rad, a map in the plane allows "
            f"{MAX_TILT_RAD}: check the transform of its frame, or leave it out"
        )
    moved = T_base_sonar.translation
    return SE2(float(moved[0]), float(moved[1]), float(np.arctan2(y, x)))


def infrared_warning(frames: Iterable[str]) -> str:
    """Return what to say of infrared rangers, by their frames."""
    return (
        f"{', '.join(sorted(frames))}: infrared rangers see through glass and would erase it, "
        "their readings are left out"
    )
