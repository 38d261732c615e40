"""Laser beams placed in the map: what both kinds of grid are filled from."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2


@dataclass(frozen=True)
class Beams:
    """Beams with their origins.

    Attributes:
        origins: Where the sensor was at each, in the map frame, shape (N, 2), m.
        angles: Directions in the map frame, shape (N,), rad.
        ranges: Measured ranges, or the length known to be free, shape (N,), m.
        is_hit: True where the range is an obstacle, shape (N,).
        angle_increment: Between neighbouring beams, > 0, rad.
    """

    origins: np.ndarray
    angles: np.ndarray
    ranges: np.ndarray
    is_hit: np.ndarray
    angle_increment: float


def beams_of(scan: Scan, T_map_laser: SE2, no_return_free_m: float) -> Beams:
    """Place the usable beams of a scan in the map.

    Args:
        scan: NaN and `-inf` beams say nothing and are left out.
        T_map_laser: Pose of the sensor.
        no_return_free_m: Length that a beam without return (`+inf`, REP 117) shows to be free,
            at most the scan's range_max; 0 leaves such beams out.
    """
    angles, ranges, is_hit, number = _usable_beams(
        scan.ranges, T_map_laser.yaw + scan.angle_min, scan.angle_step,
        scan.range_min, scan.range_max, min(no_return_free_m, scan.range_max),
    )  # fmt: skip
    moved = scan.origins()
    if moved is None:
        origins = np.empty((len(angles), 2))
        origins[:] = T_map_laser.x, T_map_laser.y
    else:
        origins = T_map_laser @ moved[number]
    return Beams(origins, angles, ranges, is_hit, abs(scan.angle_step))


@numba.njit(cache=True)
def _usable_beams(  # type: ignore[no-untyped-def]
    measured, first, increment, range_min, range_max, free
):
    angles, ranges = np.empty(len(measured)), np.empty(len(measured))
    is_hit, number = np.empty(len(measured), np.bool_), np.empty(len(measured), np.int64)
    num = 0
    for i in range(len(measured)):
        r = measured[i]
        hit = range_min <= r <= range_max and 0.0 < r < np.inf
        if hit or (r == np.inf and free > 0.0):
            angles[num], ranges[num], is_hit[num] = first + i * increment, r if hit else free, hit
            number[num] = i
            num += 1
    return angles[:num], ranges[:num], is_hit[:num], number[:num]
