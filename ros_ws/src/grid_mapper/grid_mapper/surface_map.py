"""The map that scans are fitted to: a grid of cells that hold what surfaces were seen in them.

Each cell holds the mean of the points seen in it and the mean of their surface covariances
(voxelised GICP, Koide et al. 2021, in two dimensions), apart for the two sides of a wall: both
faces of a thin wall lie in one cell, and a scan of one room must not be fitted to the next room's.
"""

from __future__ import annotations

import numba
import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.surface_points import SurfacePoints
from grid_mapper.tile_grid import TILE_MASK, TileGrid, find_slot, missing_tiles

# What a cell holds for each of two faces: count, mean (m), mean covariance (m^2), mean normal.
N, MX, MY, CXX, CXY, CYY, NX, NY = range(8)
NUM_FACES, NUM_VALUES = 2, 8


class SurfaceMap:
    """Surface cells of edge `cell_m`, each fixed after `max_points` points a face."""

    def __init__(self, cell_m: float) -> None:
        self.grid = TileGrid(cell_m, cells=(np.float64, (NUM_FACES, NUM_VALUES)))

    def insert(self, scan: SurfacePoints, T_map_base: SE2, max_points: int) -> None:
        """Add the points of a scan, given in the base frame, at its pose."""
        moved, grid = scan.moved(T_map_base), self.grid
        cells = np.floor(moved.points[:, ::-1] / grid.resolution).astype(np.int64)
        grid.ensure_tiles(missing_tiles(cells, grid.table, grid.corner))
        _insert(
            moved.points, moved.covs, moved.normals, cells, grid.fields["cells"], grid.table,
            grid.corner, max_points,
        )  # fmt: skip


@numba.njit(cache=True)
def _insert(  # type: ignore[no-untyped-def]
    points, covs, normals, cells, pool, table, corner, max_points
):
    for i in range(len(points)):
        row, col = cells[i]
        faces = pool[find_slot(table, corner, row, col), row & TILE_MASK, col & TILE_MASK]
        nx, ny = normals[i]
        is_behind = faces[0, N] > 0.0 and faces[0, NX] * nx + faces[0, NY] * ny < 0.0
        cell = faces[1 if is_behind else 0]
        if cell[N] >= max_points:
            continue
        cell[N] += 1.0
        share = 1.0 / cell[N]
        cell[MX] += share * (points[i, 0] - cell[MX])
        cell[MY] += share * (points[i, 1] - cell[MY])
        for k in range(3):
            cell[CXX + k] += share * (covs[i, k] - cell[CXX + k])
        cell[NX] += share * (nx - cell[NX])
        cell[NY] += share * (ny - cell[NY])


@numba.njit(cache=True, inline="always")
def nearest_cell(  # type: ignore[no-untyped-def]
    x, y, nx, ny, pool, table, corner, cell_m, max_distance
):
    """Find the cell whose mean is nearest to (x, y), among faces turned the same way.

    Args:
        x: Of the point, map frame, m.
        y: Of the point, map frame, m.
        nx: Of its normal; 0 for a point without one.
        ny: Of its normal.
        pool: Cells, see `SurfaceMap`.
        table: See TileGrid.
        corner: See TileGrid.
        cell_m: Cell edge, m.
        max_distance: A mean further off does not count, m.

    Returns:
        (slot, row in tile, column in tile, face); slot -1 if none is near.
    """
    row, col = int(np.floor(y / cell_m)), int(np.floor(x / cell_m))
    best = max_distance * max_distance
    best_slot, best_row, best_col, best_face = -1, 0, 0, 0
    for ring in range(2):
        for r in range(row - ring, row + ring + 1):
            for c in range(col - ring, col + ring + 1):
                slot = find_slot(table, corner, r, c)
                if slot < 0:
                    continue
                faces = pool[slot, r & TILE_MASK, c & TILE_MASK]
                for face in range(NUM_FACES):
                    cell = faces[face]
                    if cell[N] == 0.0 or cell[NX] * nx + cell[NY] * ny < 0.0:
                        continue
                    distance = (cell[MX] - x) ** 2 + (cell[MY] - y) ** 2
                    if distance < best:
                        best = distance
                        best_slot, best_face = slot, face
                        best_row, best_col = r & TILE_MASK, c & TILE_MASK
        if best_slot >= 0:  # its own cell will do; the ring round it is for the rest
            break
    return best_slot, best_row, best_col, best_face
