"""All maps of one moment, made when they are wanted, also while mapping goes on."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.grid import UNKNOWN, OccupancyMap
from grid_mapper.fusion import Fusion, MapSource


@dataclass(frozen=True)
class Layers:
    """All maps of one moment.

    Attributes:
        occupancy: The map to drive by.
        laser: What the laser alone says; no cells without a laser.
        sonar: What the sonars alone say; no cells without a sonar.
        glass: Glass inferred: occupied there, unknown elsewhere.
    """

    occupancy: OccupancyMap
    laser: OccupancyMap
    sonar: OccupancyMap
    glass: OccupancyMap


class LayersMoment:
    """What all maps of one moment are made of.

    Making them takes as long as the floor is large. It may be done in another thread: nothing that
    the mapper goes on with is changed by it.

    Args:
        laser: Gives the laser's map of that moment.
        sonar: Gives the map of ultrasonic points of that moment.
        fusion: The method; frozen here.
    """

    def __init__(self, laser: MapSource, sonar: MapSource, fusion: Fusion) -> None:
        self._laser, self._sonar = laser, sonar
        self._fused = fusion.frozen(laser, sonar)

    def layers(self) -> Layers:
        """Return all maps."""
        return Layers(self.occupancy(), self._laser(), self._sonar(), self._fused.glass())

    def occupancy(self) -> OccupancyMap:
        """Return the map to drive by; a robot without laser drives by the sonars' map."""
        laser = self._laser()
        has_laser = laser.cells.size > 0 and bool((laser.cells != UNKNOWN).any())
        return self._fused.occupancy(laser) if has_laser else self._sonar()
