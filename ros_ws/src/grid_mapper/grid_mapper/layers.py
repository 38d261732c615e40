"""Laser map, ultrasonic map, glass and their sum, filled from scans and sonar readings.

A sonar reading is placed at its own stamp, between the poses of the scans round it (glass paper,
section 3), so it waits for the next trusted scan. Into the ultrasonic map go readings apart from
each other in space, each sonar by itself, so that its points depend on no sensor's rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.fusion import Fusion, MapSource, make_fusion
from grid_mapper.layers_moment import Layers, LayersMoment
from grid_mapper.mapper import GridMapper
from grid_mapper.match_verdict import ScanResult
from grid_mapper.placed_readings import PlacedReadings
from grid_mapper.sonar_grid import SonarGrid
from grid_mapper.sonar_keys import SonarKeys
from grid_mapper.sonar_reading import Nothing, classify
from grid_mapper.start_map import StartMap
from grid_mapper.surface_points import SurfacePoints


@dataclass
class SonarCounts:
    """What became of sonar readings.

    Attributes:
        placed: Put into the maps' frame.
        void: Of these, saying nothing; see `sonar_reading`.
        counted: Of these, far enough from the last of that sonar to enter the ultrasonic map.
        unplaced: Left out: no trusted scans near enough in time on both sides of their stamp, or a
            stamp far ahead of all scans.
    """

    placed: int = 0
    void: int = 0
    counted: int = 0
    unplaced: int = 0


class _Grid(Protocol):
    def frozen(self) -> _Grid: ...

    def occupancy(self) -> OccupancyMap: ...


class LayeredMapper:
    """Turns scans and sonar readings into poses and layers.

    Attributes:
        laser: Poses and the laser's map.
        sonar_counts: What became of readings so far.
    """

    def __init__(
        self, config: GridMapperConfig, T_map_start: SE2 | None = None,
        start: StartMap | None = None, is_frozen: bool = False,
    ) -> None:  # fmt: skip
        """Start with empty maps, or with one that was made before; see `GridMapper`."""
        self.config, self._is_frozen = config, is_frozen
        self.laser = GridMapper(config, T_map_start, start, is_frozen)
        self._empty_layers()

    def reset(self) -> None:
        """Forget the maps and the pose."""
        self.laser.reset()
        self._empty_layers()

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        self.config = config
        self.laser.reconfigure(config)
        self._sonar.config = config.sonar
        self._fusion.reconfigure(config)
        self._forget_maps()

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanResult:
        """Localize and map one scan, and place the readings that waited for it.

        Args:
            stamp_ns: Of the scan.
            scan: In the laser's frame.
            T_base_laser: Pose of the laser on the robot.
            T_odom_base: Odometry at the stamp; None to expect steady motion instead.
        """
        scan = self.laser.deskewed(stamp_ns, scan, T_base_laser, T_odom_base)
        result = self.laser.insert_scan(stamp_ns, scan, T_base_laser, T_odom_base)
        if result.is_trusted:
            self._took_scan(stamp_ns, scan, T_base_laser, result.T_map_base)
        return result

    def follow_scan(self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        """Map one scan at a known pose, and place the readings that waited for it."""
        self.laser.place_scan(stamp_ns, scan, T_base_laser, T_map_base)
        self._took_scan(stamp_ns, scan, T_base_laser, T_map_base)

    def insert_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str
    ) -> None:
        """Take one sonar reading; it is placed once the scans round it have their poses.

        Args:
            stamp_ns: Of the reading.
            reading: As the driver sent it.
            T_base_sonar: Pose of the sonar on the robot, which looks along its x axis.
            sensor: Tells sonars apart.
        """
        if not self._is_frozen:
            self._readings.push(stamp_ns, reading, T_base_sonar, sensor)
            self._place_waiting()

    def place_scan(self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        """Map one scan at a pose that another localizer knows."""
        self.laser.place_scan(stamp_ns, scan, T_base_laser, T_map_base)
        self._fusion.add_scan(self.laser.clipped(scan), T_map_base @ T_base_laser, stamp_ns)

    def place_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str, T_map_base: SE2
    ) -> None:
        """Map one sonar reading at a pose that is known: of a localizer, or of odometry alone."""
        T_map_sonar = T_map_base @ T_base_sonar
        self.sonar_counts.placed += 1
        self._fusion.add_range(reading, T_map_sonar, stamp_ns)
        heard = classify(reading)
        if isinstance(heard, Nothing):
            self.sonar_counts.void += 1
            return
        keys = self._keys.setdefault(sensor, SonarKeys())
        is_counted = keys.take(stamp_ns, T_map_base, self.config.sonar_key)
        if is_counted:
            self._sonar.add_range(reading, T_map_sonar)
            self.sonar_counts.counted += 1
        # Only panes are weighed by readings of one place too, and by none without a distance.
        is_weighed = self.config.fusion == "bayes" and math.isfinite(heard.range)
        self._num_heard += is_counted or is_weighed

    def relocate(
        self, T_map_base: SE2, cov: np.ndarray | None = None, seen: SurfacePoints | None = None
    ) -> None:
        """Go on from another pose, see `ScanLocalizer.relocate`; the map has what is seen there."""
        self.laser.relocate(T_map_base, cov)
        self._readings.break_here()

    def lose(self) -> None:
        """Follow odometry alone until `relocate`; see `ScanLocalizer.lose`."""
        self.laser.lose()

    def break_motion(self) -> None:
        """Forget the motion so far: time or odometry jumped. Maps and pose stay."""
        self.laser.break_motion()
        self._readings.clear()
        self.sonar_counts.unplaced = self._readings.num_unplaced

    def moment(self) -> LayersMoment:
        """Return what makes all maps as they stand; quick, however large the floor is."""
        return LayersMoment(self._laser_source(), self._sonar_source(), self._fusion)

    def layers(self) -> Layers:
        """Return all maps as they stand."""
        return self.moment().layers()

    def occupancy(self) -> OccupancyMap:
        """Return the map to drive by; a robot without laser drives by the sonars' map."""
        return self.moment().occupancy()

    def laser_map(self) -> OccupancyMap:
        """Return what the laser alone says."""
        return self._laser_source()()

    def sonar_map(self) -> OccupancyMap:
        """Return what the sonars alone say, by the published rule."""
        return self._sonar_source()()

    def sonar_points(self) -> tuple[np.ndarray, SE2]:
        """Return the points of the ultrasonic map; see `SonarGrid.points`."""
        return self._sonar.points()

    def glass_map(self) -> OccupancyMap:
        """Return glass inferred: occupied there, unknown elsewhere."""
        return self._fusion.glass()

    @property
    def num_changes(self) -> int:
        """Grows whenever one of the maps may have changed."""
        return self.laser.num_key_scans + self._num_heard

    @property
    def num_bytes(self) -> int:
        """Bytes held by the localizer, the published grids and the fusion."""
        return self.laser.num_bytes + self._sonar.num_bytes + self._fusion.num_bytes

    def _took_scan(self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        if self._is_frozen:
            return
        self._fusion.add_scan(self.laser.clipped(scan), T_map_base @ T_base_laser, stamp_ns)
        self._readings.add_pose(stamp_ns, T_map_base)
        self._place_waiting()

    def _empty_layers(self) -> None:
        self.sonar_counts = SonarCounts()
        self._sonar = SonarGrid(self.config.sonar, self.config.resolution_m)
        self._fusion: Fusion = make_fusion(self.config, self.laser_map, self.sonar_map)
        self._keys: dict[str, SonarKeys] = {}
        self._readings = PlacedReadings()
        self._num_heard = 0
        self._forget_maps()

    def _forget_maps(self) -> None:
        """Make all maps anew; another thread may go on filling what was held so far."""
        self._maps: dict[str, tuple[int, OccupancyMap]] = {}

    def _laser_source(self) -> MapSource:
        return self._source("laser", self.laser.num_key_scans, self.laser.grid)

    def _sonar_source(self) -> MapSource:
        return self._source("sonar", self.sonar_counts.counted, self._sonar)

    def _source(self, name: str, version: int, grid: _Grid) -> MapSource:
        """Return what gives a map of this version, made once, when it is first asked for."""
        maps, frozen = self._maps, grid.frozen()

        def source() -> OccupancyMap:
            held = maps.get(name)
            if held is None or held[0] != version:
                held = maps[name] = (version, frozen.occupancy())
            return held[1]

        return source

    def _place_waiting(self) -> None:
        """Place the readings that the newest trusted scan has caught up with."""
        for w, pose in self._readings.take(self.config.sonar.max_pose_gap_s):
            self.place_range(w.stamp_ns, w.reading, w.T_base_sonar, w.sensor, pose)
        self.sonar_counts.unplaced = self._readings.num_unplaced
