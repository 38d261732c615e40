"""Laser beams placed in the map: what both kinds of grid are filled from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.tile_grid import tiles_on_rays


@dataclass(frozen=True)
class Beams:
    """Beams with one origin.

    Attributes:
        origin: Of the sensor in the map frame, shape (2,), m.
        angles: Directions in the map frame, shape (N,), rad.
        ranges: Measured ranges, or the length known to be free, shape (N,), m.
        is_hit: True where the range is an obstacle, shape (N,).
        angle_increment: Between neighbouring beams, > 0, rad.
    """

    origin: np.ndarray
    angles: np.ndarray
    ranges: np.ndarray
    is_hit: np.ndarray
    angle_increment: float

    def tiles(self, resolution: float, margin: float) -> np.ndarray:
        """Return the tiles these beams touch; `margin` (m) is added to each range."""
        reach = (self.ranges + margin)[:, None]
        ends = self.origin + reach * np.column_stack((np.cos(self.angles), np.sin(self.angles)))
        return tiles_on_rays(self.origin, ends, resolution)


def beams_of(scan: Scan, T_map_laser: SE2, no_return_free_m: float) -> Beams:
    """Place the usable beams of a scan in the map.

    Args:
        scan: NaN and `-inf` beams say nothing and are left out.
        T_map_laser: Pose of the sensor.
        no_return_free_m: Length that a beam without return (`+inf`, REP 117) shows to be free,
            at most the scan's range_max; 0 leaves such beams out.
    """
    is_hit = scan.is_hit
    is_clear = np.isposinf(scan.ranges) if no_return_free_m > 0.0 else np.zeros_like(is_hit)
    used = is_hit | is_clear
    free = min(no_return_free_m, scan.range_max)
    ranges = np.where(is_hit, scan.ranges, free)[used].astype(np.float64)
    return Beams(
        origin=np.array([T_map_laser.x, T_map_laser.y]),
        angles=T_map_laser.yaw + scan.angles[used],
        ranges=ranges,
        is_hit=is_hit[used],
        angle_increment=abs(scan.angle_increment),
    )
