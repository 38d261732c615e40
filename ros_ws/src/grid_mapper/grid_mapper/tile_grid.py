"""A plane of square cells stored in tiles: it grows by itself, memory grows with the area touched.

Cell (row, col) covers x in [col, col + 1) * resolution and y in [row, row + 1) * resolution of the
map frame; rows and columns may be negative. Cells live in a pool of tiles of 64 x 64 cells; a small
table says which tile of the plane is which slot of the pool.
"""

from __future__ import annotations

import numba
import numpy as np

TILE_BITS = 6
TILE_CELLS = 1 << TILE_BITS
TILE_MASK = TILE_CELLS - 1
NO_TILE = -1
NOWHERE = 1 << 40  # a tile row no plane has


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
def tiles_on_rays(origin: np.ndarray, ends: np.ndarray, resolution: float) -> np.ndarray:
    """Return the tiles that straight rays can touch, with one cell of margin.

    Args:
        origin: Common start of the rays in the map frame, shape (2,), m.
        ends: Their ends, shape (N, 2), m.
        resolution: Cell edge, m.

    Returns:
        (tile row, tile col), shape (M, 2), int64, each once.
    """
    edge = resolution * TILE_CELLS
    low = np.array([origin[1], origin[0]])
    high = low.copy()
    for i in range(len(ends)):
        for k in range(2):
            low[k] = min(low[k], ends[i, 1 - k])
            high[k] = max(high[k], ends[i, 1 - k])
    first = np.floor((low - 2 * resolution) / edge).astype(np.int64)
    shape = np.floor((high + 2 * resolution) / edge).astype(np.int64) - first + 1
    touched = np.zeros((shape[0], shape[1]), np.bool_)
    last = origin
    for i in range(len(ends)):  # rays that end side by side touch the same tiles
        is_near = np.hypot(ends[i, 0] - last[0], ends[i, 1] - last[1]) < 0.125 * edge
        if i == 0 or not is_near:
            _touch(touched, first, origin, ends[i], edge, 0.125 * edge + 2 * resolution)
            last = ends[i]
    rows, cols = np.nonzero(touched)
    tiles = np.empty((len(rows), 2), np.int64)
    tiles[:, 0] = rows + first[0]
    tiles[:, 1] = cols + first[1]
    return tiles


@numba.njit(cache=True)
def _touch(touched, first, origin, end, edge, margin):  # type: ignore[no-untyped-def]
    """Mark the tiles round points half a tile apart; between them the ray cannot leave these."""
    length = np.hypot(end[0] - origin[0], end[1] - origin[1])
    num_steps = int(2.0 * length / edge) + 1
    reach = 0.25 * edge + margin
    for k in range(num_steps + 1):
        x = origin[0] + (end[0] - origin[0]) * k / num_steps
        y = origin[1] + (end[1] - origin[1]) * k / num_steps
        row0 = max(int(np.floor((y - reach) / edge)) - first[0], 0)
        col0 = max(int(np.floor((x - reach) / edge)) - first[1], 0)
        row1 = min(int(np.floor((y + reach) / edge)) - first[0], touched.shape[0] - 1)
        col1 = min(int(np.floor((x + reach) / edge)) - first[1], touched.shape[1] - 1)
        touched[row0, col0] = touched[row0, col1] = True
        touched[row1, col0] = touched[row1, col1] = True
