"""The laser mapper: every scan gets its pose, key scans enter the grid (glass paper, 3 and 4)."""

from __future__ import annotations

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_scans import KeyScans
from grid_mapper.label_grid import LabelGrid
from grid_mapper.localizer import ScanLocalizer
from grid_mapper.log_odds import LogOddsGrid
from grid_mapper.map_surfaces import surfaces_of
from grid_mapper.match_verdict import ScanResult
from grid_mapper.scan_matcher import ScanMatcher
from grid_mapper.start_map import StartMap, known_cells
from grid_mapper.sweeps import SweepOrder


class GridMapper:
    """Turns scans into poses and a map; what it holds grows with the area seen, not with time.

    Attributes:
        config: Its values; change them with `reconfigure`.
        grid: The grid by the rule chosen.
        num_key_scans: Scans that entered the grid.
    """

    def __init__(
        self, config: GridMapperConfig, T_map_start: SE2 | None = None,
        start: StartMap | None = None, is_frozen: bool = False,
    ) -> None:  # fmt: skip
        """Start with a map, an empty one by default.

        Args:
            config: Its values.
            T_map_start: The first pose, the map's origin by default; with a map to begin with it
                is not known before `relocate`.
            start: The map to begin with.
            is_frozen: Whether it is to stay as it is.
        """
        self.config = config
        self._T_map_start, self._start, self._is_frozen = T_map_start, start, is_frozen
        self.reset()

    def reset(self) -> None:
        """Forget the map and the pose."""
        config = self.config
        matcher = ScanMatcher(config.matcher)
        frozen = self._is_frozen
        self._localizer = ScanLocalizer(config, self._T_map_start, matcher, frozen)
        self._keys = KeyScans()
        self.num_key_scans = 0
        self.grid: LabelGrid | LogOddsGrid = (
            LabelGrid(config.label, config.resolution_m)
            if config.grid == "label"
            else LogOddsGrid(config.log_odds, config.resolution_m)
        )
        if self._start is not None:
            matcher.insert(surfaces_of(self._start.laser), SE2.identity())
            self.grid.begin_with(*known_cells(self._start.occupancy, config.resolution_m))
            self.lose()

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
        scan = self.deskewed(stamp_ns, self.clipped(scan), T_base_laser, T_odom_base)
        result = self._localizer.localize(stamp_ns, scan, T_base_laser, T_odom_base)
        if result.is_trusted:
            self._map(stamp_ns, scan, result.T_map_base, T_base_laser)
        return result

    def deskewed(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> Scan:
        """Return a scan as seen from one place; see `ScanLocalizer.deskewed`."""
        return self._localizer.deskewed(stamp_ns, scan, T_base_laser, T_odom_base)

    @property
    def sweeps(self) -> SweepOrder:
        """In which order the beams of a scan are taken."""
        return self._localizer.sweeps

    def place_scan(self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        """Map one scan at a pose that another localizer knows, if the robot has moved on."""
        self._map(stamp_ns, self.clipped(scan), T_map_base, T_base_laser)

    def relocate(self, T_map_base: SE2, cov: np.ndarray | None = None) -> None:
        """Go on from another pose; see `ScanLocalizer.relocate`."""
        self._localizer.relocate(T_map_base, cov)

    def lose(self) -> None:
        """Follow odometry alone until `relocate`; see `ScanLocalizer.lose`."""
        self._localizer.lose()

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
        if self._is_frozen:
            return
        if self._keys.take(stamp_ns, T_map_base, self.config.map_key):
            self.grid.add_scan(scan, T_map_base @ T_base_laser)
            self.num_key_scans += 1
