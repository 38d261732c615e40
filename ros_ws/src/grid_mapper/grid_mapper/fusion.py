"""How laser and sonar become one map: the methods by name (parameter `fusion`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from floornav_common.grid import UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.bayes_fusion import BayesFusion
from grid_mapper.config import GridMapperConfig
from grid_mapper.overlay import glass_layer, overlay

MapSource = Callable[[], OccupancyMap]


class FusedMaps(Protocol):
    """What a method makes of all that it was given so far."""

    def glass(self) -> OccupancyMap:
        """Return what was inferred to be glass: 100 there, unknown elsewhere."""
        ...

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the map to drive by, on the lattice of the laser's."""
        ...


class Fusion(FusedMaps, Protocol):
    """What a method is asked for; every trusted scan and every placed reading goes to it."""

    def frozen(self, laser_map: MapSource, sonar_map: MapSource) -> FusedMaps:
        """Return it as it stands, for another thread to make maps of.

        Args:
            laser_map: Gives the laser's map of that moment.
            sonar_map: Gives the map of ultrasonic points of that moment.
        """
        ...

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int) -> None:
        """Take a scan at its pose."""
        ...

    def add_range(self, reading: RangeReading, T_map_sonar: SE2, stamp_ns: int) -> None:
        """Take a sonar reading at its pose."""
        ...

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        ...

    @property
    def num_bytes(self) -> int:
        """Bytes held beside the laser's and the sonars' maps."""
        ...


class OverlayFusion:
    """The published rule (glass paper, section 6), over the laser's map and the sonars'."""

    def __init__(self, laser_map: MapSource, sonar_map: MapSource) -> None:
        self._laser_map = laser_map
        self._sonar_map = sonar_map

    def frozen(self, laser_map: MapSource, sonar_map: MapSource) -> FusedMaps:
        """Return the rule over other maps."""
        return OverlayFusion(laser_map, sonar_map)

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int) -> None:
        """Keep nothing: the laser's map has it."""

    def add_range(self, reading: RangeReading, T_map_sonar: SE2, stamp_ns: int) -> None:
        """Keep nothing: the sonars' map has it."""

    def glass(self) -> OccupancyMap:
        """Return the sonar's obstacles where the laser says free."""
        return glass_layer(self._laser_map(), self._sonar_map())

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the overlay of both maps."""
        return overlay(laser_map, self._sonar_map())

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Change nothing: the rule has no values of its own."""

    @property
    def num_bytes(self) -> int:
        """Return 0."""
        return 0


class NoFusion:
    """The laser's map as it is; no glass."""

    def __init__(self, laser_map: MapSource) -> None:
        self._laser_map = laser_map

    def frozen(self, laser_map: MapSource, sonar_map: MapSource) -> FusedMaps:
        """Return the laser's map of that moment."""
        return NoFusion(laser_map)

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int) -> None:
        """Keep nothing."""

    def add_range(self, reading: RangeReading, T_map_sonar: SE2, stamp_ns: int) -> None:
        """Keep nothing."""

    def glass(self) -> OccupancyMap:
        """Return a layer without glass."""
        laser = self._laser_map()
        cells = np.full(laser.cells.shape, UNKNOWN, np.int8)
        return OccupancyMap(cells, laser.resolution, laser.origin)

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the laser's map."""
        return laser_map

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Change nothing."""

    @property
    def num_bytes(self) -> int:
        """Return 0."""
        return 0


def make_fusion(config: GridMapperConfig, laser_map: MapSource, sonar_map: MapSource) -> Fusion:
    """Return the method that a configuration names, empty.

    Args:
        config: Names it in `fusion`.
        laser_map: Gives the laser's map as it stands.
        sonar_map: Gives the map of ultrasonic points as it stands.
    """
    makers: dict[str, Callable[[], Fusion]] = {
        "overlay": lambda: OverlayFusion(laser_map, sonar_map),
        "bayes": lambda: BayesFusion(config),
        "none": lambda: NoFusion(laser_map),
    }
    return makers[config.fusion]()
