"""A range finder that repeats itself: its ranges stay the same while the robot moves.

A driver that hangs may send its last measurement again and again, with new stamps. No single
message shows that; but no real sensor measures the very same ranges in many directions from two
places, for its noise alone.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2

_MOVED_M, _TURNED_RAD = 0.05, 0.05
_LEAST_SHARE = 0.2  # of the beams: in the open, "nothing near" may be true twice


class StuckScan:
    """Compares each scan with those before it; nothing here reads a clock.

    Attributes:
        fault: What is wrong with the newest scan; "" for nothing.
    """

    def __init__(self) -> None:
        self.fault = ""
        self._ranges = np.zeros(0)
        self._T_fixed_base: SE2 | None = None

    def take(self, ranges: np.ndarray, T_fixed_base: SE2) -> None:
        """Take a scan; it has a fault if it is still the one of a place that the robot has left.

        Args:
            ranges: As measured, shape (N,), m.
            T_fixed_base: Where the robot was, in any frame that does not move with it.
        """
        self.fault = ""
        is_same = np.array_equal(ranges, self._ranges, equal_nan=True)
        if not is_same or self._T_fixed_base is None:
            self._ranges, self._T_fixed_base = ranges.copy(), T_fixed_base
            return
        moved = self._T_fixed_base.inverse() @ T_fixed_base
        far = math.hypot(moved.x, moved.y)
        is_elsewhere = far > _MOVED_M or abs(moved.yaw) > _TURNED_RAD
        if is_elsewhere and np.isfinite(ranges).mean() >= _LEAST_SHARE:
            text = f"the same ranges again after the robot moved {far:.2f} m"
            self.fault = f"{text}: the sensor is stuck"
