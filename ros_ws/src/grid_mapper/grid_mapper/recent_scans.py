"""The map of what was seen lately: matching to it drifts, but never to a wall of long ago."""

from __future__ import annotations

from collections import deque

from floornav_common.se2 import SE2
from grid_mapper.config import ScanMatcherConfig
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.surface_map import SurfaceMap
from grid_mapper.surface_points import SurfacePoints


class RecentScanMatcher(ScanMatcher):
    """Fits scans to the key scans of late; between `num_recent` and twice as many are held."""

    def __init__(self, config: ScanMatcherConfig, num_recent: int) -> None:
        super().__init__(config)
        self._num_recent = num_recent
        self._recent: deque[tuple[SurfacePoints, SE2]] = deque()

    def insert(self, scan: SurfacePoints, T_map_base: SE2) -> None:
        """Add a scan at its pose; the oldest are forgotten from time to time."""
        self._recent.append((scan, T_map_base))
        if len(self._recent) < 2 * self._num_recent:
            super().insert(scan, T_map_base)
            return
        while len(self._recent) > self._num_recent:
            self._recent.popleft()
        self._map = SurfaceMap(self.config.cell_m)
        for points, pose in self._recent:
            super().insert(points, pose)

    def as_state(self) -> list[tuple[SurfacePoints, SE2]]:
        """Return the scans held, from which the map is made."""
        return list(self._recent)

    def take_state(self, recent: list[tuple[SurfacePoints, SE2]]) -> None:
        """Go on with scans that were held before."""
        self._recent.clear()
        self._map = SurfaceMap(self.config.cell_m)
        for points, pose in recent:
            self.insert(points, pose)
