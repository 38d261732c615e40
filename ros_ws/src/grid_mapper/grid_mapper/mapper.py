"""The laser mapper: every scan gets its pose, key scans enter the grid (glass paper, 3 and 4)."""

from __future__ import annotations

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_scans import KeyScans
from grid_mapper.label_grid import LabelGrid
from grid_mapper.localizer import ScanLocalizer, ScanResult
from grid_mapper.log_odds import LogOddsGrid


class GridMapper:
    """Turns scans into poses and a map; what it holds grows with the area seen, not with time.

    Attributes:
        config: Its values; change them with `reconfigure`.
        grid: The grid by the rule chosen.
        num_key_scans: Scans that entered the grid.
    """

    def __init__(self, config: GridMapperConfig, T_map_start: SE2 | None = None) -> None:
        """Start with an empty map; `T_map_start` is the first pose, the map's origin by default."""
        self.config = config
        self._T_map_start = T_map_start
        self.reset()

    def reset(self) -> None:
        """Forget the map and the pose."""
        config = self.config
        self._localizer = ScanLocalizer(config, self._T_map_start)
        self._keys = KeyScans()
        self.num_key_scans = 0
        self.grid: LabelGrid | LogOddsGrid = (
            LabelGrid(config.label, config.resolution_m)
            if config.grid == "label"
            else LogOddsGrid(config.log_odds, config.resolution_m)
        )

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        self.config = config
        self._localizer.reconfigure(config)
        if isinstance(self.grid, LabelGrid):
            self.grid.config = config.label
        else:
            self.grid.config = config.log_odds

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanResult:
        """Localize one scan, and map it if the robot has moved on.

        Args:
            stamp_ns: Of the scan.
            scan: In the laser's frame.
            T_base_laser: Pose of the laser on the robot.
            T_odom_base: Odometry at the stamp; None to expect steady motion instead.
        """
        scan = self.clipped(scan)
        result = self._localizer.localize(stamp_ns, scan, T_base_laser, T_odom_base)
        if result.is_trusted:
            self._map(stamp_ns, scan, result.T_map_base, T_base_laser)
        return result

    def place_scan(self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        """Map one scan at a pose that another localizer knows, if the robot has moved on."""
        self._map(stamp_ns, self.clipped(scan), T_map_base, T_base_laser)

    def relocate(self, T_map_base: SE2, cov: np.ndarray | None = None) -> None:
        """Go on from another pose; see `ScanLocalizer.relocate`."""
        self._localizer.relocate(T_map_base, cov)

    def break_motion(self) -> None:
        """Forget the motion so far: time or odometry jumped. The map and the pose stay."""
        self._localizer.break_motion()

    def occupancy(self) -> OccupancyMap:
        """Return the map as it stands."""
        return self.grid.occupancy()

    @property
    def num_bytes(self) -> int:
        """Bytes held by the map to match to and the grid."""
        return self._localizer.num_bytes + self.grid.num_bytes

    def clipped(self, scan: Scan) -> Scan:
        """Return the scan with the configured range limits beside its own."""
        return self.config.clipped(scan)

    def _map(self, stamp_ns: int, scan: Scan, T_map_base: SE2, T_base_laser: SE2) -> None:
        """Add a key scan to the grid."""
        if self._keys.take(stamp_ns, T_map_base, self.config.map_key):
            self.grid.add_scan(scan, T_map_base @ T_base_laser)
            self.num_key_scans += 1
