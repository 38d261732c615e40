"""The log-odds occupancy grid that the field uses (Thrun et al. 2005, Table 9.1).

Each beam is a ray: cells it crosses become freer, the cell it ends in more occupied.
"""

from __future__ import annotations

from copy import copy

import numba
import numpy as np

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.beams import Beams, beams_of
from grid_mapper.config import LogOddsConfig
from grid_mapper.tile_grid import NOWHERE, TILE_BITS, TILE_MASK, TileGrid, find_slot

EVEN = np.float32(1e-6)


class LogOddsGrid:
    """Log-odds of every cell seen; exactly 0 means never seen, `EVEN` as likely as not."""

    def __init__(self, config: LogOddsConfig, resolution: float) -> None:
        self.config = config
        self._grid = TileGrid(resolution, log_odds=(np.float32, ()))

    def add_scan(self, scan: Scan, T_map_laser: SE2) -> None:
        """Trace one scan."""
        self.add_beams(beams_of(scan, T_map_laser, self.config.no_return_free_m))

    def add_beams(self, beams: Beams) -> None:
        """Trace beams given in the map frame."""
        grid, config = self._grid, self.config
        steps = [np.float32(log_odds(p)) for p in (config.p_miss, config.p_hit, config.p_max)]
        origins, ranges = beams.origins / grid.resolution, beams.ranges / grid.resolution
        grid.ensure_rays(origins, beams.angles, ranges)
        trace_rays(
            origins, beams.angles, ranges, beams.is_hit, *steps,
            grid.fields["log_odds"], grid.table, grid.corner,
        )  # fmt: skip

    def begin_with(self, cells: np.ndarray, values: np.ndarray) -> None:
        """Take cells (row, col), shape (N, 2), that are known for sure: FREE or OCCUPIED."""
        limit = np.float32(log_odds(self.config.p_max))
        self._grid.write("log_odds", cells, np.where(values == OCCUPIED, limit, -limit))

    def occupancy(self) -> OccupancyMap:
        """Return the map; cells hold 100 P(occupied), rounded."""
        values, corner = self._grid.dense("log_odds")
        percent = np.rint(100.0 / (1.0 + np.exp(-values))).astype(np.int8)
        percent[values == 0.0] = UNKNOWN
        resolution = self._grid.resolution
        origin = SE2(float(corner[1] * resolution), float(corner[0] * resolution), 0.0)
        return OccupancyMap(percent, resolution, origin)

    def frozen(self) -> LogOddsGrid:
        """Return the grid as it stands, for another thread to read; see `TileGrid.frozen`."""
        there = copy(self)
        there._grid = self._grid.frozen()
        return there

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._grid.num_bytes


def log_odds(p: float) -> float:
    """Return log(p / (1 - p))."""
    return float(np.log(p / (1.0 - p)))


@numba.njit(cache=True)
def trace_rays(  # type: ignore[no-untyped-def]
    origins, angles, ranges, is_hit, miss, hit, limit, values, table, corner
):
    """Walk every ray cell by cell (Bresenham 1965); lengths are in cells.

    Args:
        origins: Of the rays, shape (N, 2), cells.
        angles: Of the rays, shape (N,), rad.
        ranges: Their lengths, shape (N,), cells.
        is_hit: False for rays that end in free space, shape (N,).
        miss: Log-odds added to a crossed cell, < 0.
        hit: Log-odds added to the cell a hit ends in, > 0.
        limit: Greatest absolute value a cell takes.
        values: Pool of log-odds, changed in place.
        table: See TileGrid.
        corner: See TileGrid.
    """
    for i in range(len(angles)):
        x, y = origins[i, 0], origins[i, 1]
        end_col = int(np.floor(x + ranges[i] * np.cos(angles[i])))
        end_row = int(np.floor(y + ranges[i] * np.sin(angles[i])))
        col, row = int(np.floor(x)), int(np.floor(y))
        num_cols, num_rows = abs(end_col - col), abs(end_row - row)
        step_col, step_row = (1 if end_col > col else -1), (1 if end_row > row else -1)
        error = num_cols - num_rows
        tile_row, tile_col, tile = NOWHERE, NOWHERE, values[0]
        last = max(num_cols, num_rows)
        for k in range(last + 1):
            if row >> TILE_BITS != tile_row or col >> TILE_BITS != tile_col:
                tile_row, tile_col = row >> TILE_BITS, col >> TILE_BITS
                slot = find_slot(table, corner, row, col)
                if slot < 0:
                    break  # nothing is stored there; `ensure_rays` leaves no such tile
                tile = values[slot]
            r, c = row & TILE_MASK, col & TILE_MASK
            if k == last and is_hit[i]:
                value = min(tile[r, c] + hit, limit)
            else:
                value = max(tile[r, c] + miss, -limit)
            tile[r, c] = value if value != 0.0 else EVEN
            twice = 2 * error
            if twice > -num_rows:
                error -= num_rows
                col += step_col
            if twice < num_cols:
                error += num_cols
                row += step_row
