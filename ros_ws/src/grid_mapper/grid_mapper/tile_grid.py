"""A plane of square cells stored in tiles: it grows by itself, memory grows with the area touched.

Cell (row, col) covers x in [col, col + 1) * resolution and y in [row, row + 1) * resolution of the
map frame; rows and columns may be negative. Cells live in a pool of tiles of 64 x 64 cells; a small
table says which tile of the plane is which slot of the pool.
"""

from __future__ import annotations

from copy import copy

import numba
import numpy as np

TILE_BITS = 6
TILE_CELLS = 1 << TILE_BITS
TILE_MASK = TILE_CELLS - 1
NO_TILE = -1
NOWHERE = 1 << 40  # a tile row no plane has
NEAR_CELLS = 8.0
SIDE_CELLS = 6.0  # beside a ray, for sectors


class TileGrid:
    """Cells of one record each, in tiles made on demand.

    Attributes:
        table: Slot of each tile, shape (tile rows, tile cols), int32; -1 where nothing is stored.
        corner: (tile row, tile col) of `table[0, 0]`, shape (2,), int64.
        fields: Named pools, each of shape (slots, 64, 64, ...); new cells are zero.
    """

    def __init__(self, resolution: float, **fields: tuple[type, tuple[int, ...]]) -> None:
        """Make an empty plane.

        Args:
            resolution: Cell edge, m.
            fields: Per field its dtype and the shape of one cell's value (`()` for a number).
        """
        self.resolution = resolution
        self.table = np.full((1, 1), NO_TILE, np.int32)
        self.corner = np.zeros(2, np.int64)
        self.num_tiles = 0
        self.fields: dict[str, np.ndarray] = {
            name: np.zeros((1, TILE_CELLS, TILE_CELLS, *shape), dtype)
            for name, (dtype, shape) in fields.items()
        }

    def ensure_tiles(self, tiles: np.ndarray) -> None:
        """Make the given tiles exist; (tile row, tile col), shape (N, 2), int64."""
        if len(tiles) == 0:
            return
        self._cover(tiles.min(axis=0), tiles.max(axis=0))
        local = tiles - self.corner
        is_new = self.table[local[:, 0], local[:, 1]] == NO_TILE
        if not is_new.any():
            return
        new = np.unique(local[is_new], axis=0)
        self._reserve(self.num_tiles + len(new))
        self.table[new[:, 0], new[:, 1]] = np.arange(self.num_tiles, self.num_tiles + len(new))
        self.num_tiles += len(new)

    def ensure_rays(self, origins: np.ndarray, angles: np.ndarray, lengths: np.ndarray) -> None:
        """Make the tiles along straight rays exist; see `missing_on_rays`."""
        self.ensure_tiles(missing_on_rays(origins, angles, lengths, self.table, self.corner))

    def write(self, name: str, cells: np.ndarray, values: np.ndarray) -> None:
        """Set one field of cells (row, col), shape (N, 2), int64, to values, shape (N,)."""
        self.ensure_tiles(np.unique(cells >> TILE_BITS, axis=0))
        slots = self.table[tuple(((cells >> TILE_BITS) - self.corner).T)]
        self.fields[name][slots, cells[:, 0] & TILE_MASK, cells[:, 1] & TILE_MASK] = values

    def tile_corners(self) -> np.ndarray:
        """Return (row, col) of the first cell of every stored tile in slot order, shape (N, 2)."""
        rows, cols = np.nonzero(self.table != NO_TILE)
        order = np.argsort(self.table[rows, cols])
        return (np.column_stack((rows, cols))[order] + self.corner) * TILE_CELLS

    def dense(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return one field as an array over the bounding box of all tiles, and its corner.

        Returns:
            The values, shape (H, W, ...), zero where no tile is stored, and the (row, col) of
            `values[0, 0]`, shape (2,). An empty plane gives shape (0, 0, ...).
        """
        pool = self.fields[name]
        if self.num_tiles == 0:
            return np.zeros((0, 0, *pool.shape[3:]), pool.dtype), np.zeros(2, np.int64)
        corners = self.tile_corners()
        first = corners.min(axis=0)
        height, width = corners.max(axis=0) + TILE_CELLS - first
        values = np.zeros((height, width, *pool.shape[3:]), pool.dtype)
        for slot, (row, col) in enumerate(corners - first):
            values[row : row + TILE_CELLS, col : col + TILE_CELLS] = pool[slot]
        return values, first

    def frozen(self) -> TileGrid:
        """Return the plane as far as it reaches now, for another thread to read.

        Tiles made later are not in it. Cells are shared, not copied: one may be newer than this
        call, never half written.
        """
        there = copy(self)
        there.table, there.fields = self.table.copy(), dict(self.fields)
        return there

    @property
    def num_bytes(self) -> int:
        """Bytes held by the pools and the table."""
        return self.table.nbytes + sum(pool.nbytes for pool in self.fields.values())

    def _cover(self, low: np.ndarray, high: np.ndarray) -> None:
        end = self.corner + self.table.shape
        if np.all(low >= self.corner) and np.all(high < end):
            return
        is_empty = self.num_tiles == 0
        new_corner = low if is_empty else np.minimum(low, self.corner)
        new_end = high + 1 if is_empty else np.maximum(high + 1, end)
        table = np.full(new_end - new_corner, NO_TILE, np.int32)
        if not is_empty:
            r, c = self.corner - new_corner
            table[r : r + self.table.shape[0], c : c + self.table.shape[1]] = self.table
        self.table, self.corner = table, new_corner.astype(np.int64)

    def _reserve(self, num_tiles: int) -> None:
        for name, pool in self.fields.items():
            if len(pool) >= num_tiles:
                continue
            grown = np.zeros((max(num_tiles, len(pool) * 3 // 2), *pool.shape[1:]), pool.dtype)
            grown[: len(pool)] = pool
            self.fields[name] = grown


@numba.njit(cache=True, inline="always")
def find_slot(table: np.ndarray, corner: np.ndarray, row: int, col: int) -> int:
    """Return the pool slot that holds cell (row, col), or -1 if it is not stored."""
    tile_row = (row >> TILE_BITS) - corner[0]
    tile_col = (col >> TILE_BITS) - corner[1]
    if 0 <= tile_row < table.shape[0] and 0 <= tile_col < table.shape[1]:
        return table[tile_row, tile_col]
    return NO_TILE


@numba.njit(cache=True)
def missing_tiles(cells: np.ndarray, table: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Return the tiles that cells (N, 2) need and `table` has not, shape (M, 2)."""
    tiles = np.empty((len(cells), 2), np.int64)
    num = 0
    for i in range(len(cells)):
        if find_slot(table, corner, cells[i, 0], cells[i, 1]) == NO_TILE:
            row, col = cells[i, 0] >> TILE_BITS, cells[i, 1] >> TILE_BITS
            if num == 0 or tiles[num - 1, 0] != row or tiles[num - 1, 1] != col:
                tiles[num, 0], tiles[num, 1] = row, col
                num += 1
    return tiles[:num]


@numba.njit(cache=True)
def missing_on_rays(  # type: ignore[no-untyped-def]
    origins, angles, lengths, table, corner
):
    """Return the tiles that straight rays can touch and `table` has not; lengths are in cells.

    Args:
        origins: (x, y) where each ray starts, shape (N, 2), cells.
        angles: Their directions, shape (N,), rad.
        lengths: Their lengths, shape (N,), cells.
        table: See TileGrid.
        corner: See TileGrid.

    Returns:
        (tile row, tile col), shape (M, 2), int64; a tile may come more than once.
    """
    tiles = np.empty((0, 2), np.int64)
    last_x = last_y = last_x0 = last_y0 = np.inf
    for i in range(len(angles)):
        x0, y0 = origins[i]
        x, y = x0 + lengths[i] * np.cos(angles[i]), y0 + lengths[i] * np.sin(angles[i])
        # rays that begin and end side by side touch the same tiles
        aside = abs(x - last_x) + abs(y - last_y) + abs(x0 - last_x0) + abs(y0 - last_y0)
        if aside > NEAR_CELLS:
            last_x, last_y, last_x0, last_y0 = x, y, x0, y0
            for row, col in _tiles_on_ray(x0, y0, x, y):
                if find_slot(table, corner, row << TILE_BITS, col << TILE_BITS) == NO_TILE:
                    tiles = np.concatenate((tiles, np.array([[row, col]])))
    return tiles


@numba.njit(cache=True)
def _tiles_on_ray(x0, y0, x1, y1):  # type: ignore[no-untyped-def]
    """Return the tiles round points half a tile apart; between them the ray stays in these."""
    num_steps = int(2.0 * np.hypot(x1 - x0, y1 - y0) / TILE_CELLS) + 1
    reach = 0.25 * TILE_CELLS + NEAR_CELLS + SIDE_CELLS
    tiles = np.empty((4 * (num_steps + 1), 2), np.int64)
    for k in range(num_steps + 1):
        x, y = x0 + (x1 - x0) * k / num_steps, y0 + (y1 - y0) * k / num_steps
        for j in range(4):
            tiles[4 * k + j, 0] = int(np.floor(y + (reach if j & 1 else -reach))) >> TILE_BITS
            tiles[4 * k + j, 1] = int(np.floor(x + (reach if j & 2 else -reach))) >> TILE_BITS
    return tiles
