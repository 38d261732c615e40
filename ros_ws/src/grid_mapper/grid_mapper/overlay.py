"""The laser's map and the ultrasonic map laid over each other (glass paper, section 6)."""

from __future__ import annotations

import numpy as np

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap

EVEN = 50
"""Of a cell's percent: below it is free, from it on an obstacle."""


def overlay(laser: OccupancyMap, sonar: OccupancyMap) -> OccupancyMap:
    """Return the laser's map, with the sonar's obstacles where the laser says free.

    What the laser calls unknown or occupied stands.

    Args:
        laser: Laser map.
        sonar: Ultrasonic map on the same lattice; it may cover another part of it.

    Raises:
        ValueError: If the maps are not of one lattice of cells.
    """
    cells = laser.cells.copy()
    cells[_is_glass(laser, sonar)] = OCCUPIED
    return OccupancyMap(cells, laser.resolution, laser.origin)


def glass_layer(laser: OccupancyMap, sonar: OccupancyMap) -> OccupancyMap:
    """Return what only the sonar sees: occupied there, unknown everywhere else.

    Raises:
        ValueError: If the maps are not of one lattice of cells.
    """
    cells = np.full(laser.cells.shape, UNKNOWN, np.int8)
    cells[_is_glass(laser, sonar)] = OCCUPIED
    return OccupancyMap(cells, laser.resolution, laser.origin)


def on_cells_of(source: OccupancyMap, like: OccupancyMap) -> np.ndarray:
    """Return the cells of `source` cut to those of `like`, unknown where it has none.

    Raises:
        ValueError: If the maps are not of one lattice of cells.
    """
    first_col, first_row = _whole_cells(source, like)
    cells = np.full(like.cells.shape, UNKNOWN, np.int8)
    low = np.maximum((first_row, first_col), 0)
    high = np.minimum(np.array(source.cells.shape) + (first_row, first_col), cells.shape)
    if np.all(high > low):
        (r0, c0), (r1, c1) = low, high
        cells[r0:r1, c0:c1] = source.cells[
            r0 - first_row : r1 - first_row, c0 - first_col : c1 - first_col
        ]
    return cells


def _is_glass(laser: OccupancyMap, sonar: OccupancyMap) -> np.ndarray:
    """Return where the laser says free and the sonar says obstacle, shape of the laser's map."""
    is_free = (laser.cells != UNKNOWN) & (laser.cells < EVEN)
    return is_free & (on_cells_of(sonar, laser) >= EVEN)


def _whole_cells(source: OccupancyMap, like: OccupancyMap) -> tuple[int, int]:
    """Return the (col, row) of the source's first cell among those of `like`."""
    offset = like.origin.between(source.origin)
    steps = np.array([offset.x, offset.y]) / like.resolution
    whole = np.rint(steps)
    is_one = source.resolution == like.resolution and abs(offset.yaw) < 1e-9
    if not is_one or np.abs(steps - whole).max() > 1e-3:
        raise ValueError(
            f"maps must share a lattice of cells, got {source.resolution} m at {source.origin} and "
            f"{like.resolution} m at {like.origin}"
        )
    return int(whole[0]), int(whole[1])
