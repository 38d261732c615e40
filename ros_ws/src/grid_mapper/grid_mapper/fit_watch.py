"""Whether a robot that is followed in a map made before is really there.

A scan fits some walls nearly anywhere, so a robot that was carried off goes on to be believed. But
elsewhere it sees through walls that the map knows; people and things that came only hide them.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.key_frames import KeyFrame
from grid_mapper.loop_verification import seen_through
from grid_mapper.match_verdict import ScanResult
from grid_mapper.surface_points import SurfacePoints

NUM_SCANS, PERIOD_NS = 5, 100_000_000
"""So many scans count, taken at least so long after each other."""
MIN_OVERLAP = 0.45
"""Where less of these scans is near the map it is not believed, though each alone might be."""


class FitWatch:
    """Judges the newest scans together.

    Args:
        max_contradiction: Share of the map's walls that may be seen through, 0..1.
    """

    def __init__(self, max_contradiction: float) -> None:
        self._limit = max_contradiction
        self.forget()

    def forget(self) -> None:
        """Begin anew: the robot was found, or is lost."""
        self._seen: deque[tuple[float, float]] = deque(maxlen=NUM_SCANS)
        self._last_ns: int | None = None

    def is_due(self, stamp_ns: int) -> bool:
        """Tell whether a scan is to be taken."""
        return self._last_ns is None or abs(stamp_ns - self._last_ns) >= PERIOD_NS

    def doubt(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, result: ScanResult, near: SurfacePoints
    ) -> str:
        """Take a scan that was believed; return why the robot is not there after all, "" if it is.

        Args:
            stamp_ns: Of the scan.
            scan: In the laser's frame.
            T_base_laser: Pose of the laser on the robot.
            result: What became of it.
            near: Surfaces of the map round that pose, in the map frame.
        """
        self._last_ns = stamp_ns
        nothing = SurfacePoints(np.zeros((0, 2)), np.zeros((0, 3)), np.zeros((0, 2)))
        frame = KeyFrame(0, SE2.identity(), np.zeros((3, 3)), nothing, scan, T_base_laser)
        through = seen_through(frame, near.moved(result.T_map_base.inverse()))
        self._seen.append((result.overlap, through))
        if len(self._seen) < NUM_SCANS:
            return ""
        overlap, through = np.mean(self._seen, axis=0)
        if through > self._limit:
            return f"{100 * through:.0f} % of the map's walls are seen through"
        if overlap < MIN_OVERLAP:
            return f"for {NUM_SCANS} scans {100 * overlap:.0f} % of each were near the map"
        return ""
