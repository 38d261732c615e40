"""How opaque each cell is to the laser: log-odds by rays, and how often it was hit at all.

Glass is crossed by nearly every beam and sends back those along its normal and a few from dirt, so
its log-odds are low though it was hit; a wall's are high. The hits tell where a pane is, once it
is known that there is one.
"""

from __future__ import annotations

from copy import copy
from typing import NamedTuple

import numba
import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.beams import beams_of
from grid_mapper.config import LogOddsConfig
from grid_mapper.key_scans import KeyScans
from grid_mapper.log_odds import log_odds, trace_rays
from grid_mapper.sonar_config import SonarKeyConfig
from grid_mapper.tile_grid import TILE_MASK, TileGrid, find_slot

MAX_HITS = 255
APART = SonarKeyConfig(distance_m=0.05, turn_rad=0.1, period_s=0.5)
"""Scans are counted when taken so far from the last: evidence does not grow with their rate."""


class Cells(NamedTuple):
    """The cells as kernels take them; see `TileGrid`.

    Attributes:
        resolution: Edge of a cell, m.
        log_odds: Pool, > 0 where opaque.
        hits: Pool of counts.
        table: Slot of each tile.
        corner: Of the table.
    """

    resolution: float
    log_odds: np.ndarray
    hits: np.ndarray
    table: np.ndarray
    corner: np.ndarray


class OpaqueCells:
    """The laser's cells."""

    def __init__(self, resolution: float) -> None:
        self._grid = TileGrid(resolution, log_odds=(np.float32, ()), hits=(np.uint8, ()))
        self._keys = KeyScans()

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int, config: LogOddsConfig) -> None:
        """Trace a scan taken apart from the last one."""
        if not self._keys.take(stamp_ns, T_map_laser, APART):
            return
        grid = self._grid
        beams = beams_of(scan, T_map_laser, config.no_return_free_m)
        steps = [np.float32(log_odds(p)) for p in (config.p_miss, config.p_hit, config.p_max)]
        origins, ranges = beams.origins / grid.resolution, beams.ranges / grid.resolution
        grid.ensure_rays(origins, beams.angles, ranges)
        trace_rays(
            origins, beams.angles, ranges, beams.is_hit, *steps,
            grid.fields["log_odds"], grid.table, grid.corner,
        )  # fmt: skip
        hit = beams.is_hit
        count_hits(
            origins[hit], beams.angles[hit], ranges[hit], grid.fields["hits"], grid.table,
            grid.corner,
        )  # fmt: skip

    def frozen(self) -> OpaqueCells:
        """Return the cells as they stand, for another thread to read; see `TileGrid.frozen`."""
        there = copy(self)
        there._grid = self._grid.frozen()
        return there

    @property
    def cells(self) -> Cells:
        """The cells as they stand."""
        grid, fields = self._grid, self._grid.fields
        return Cells(grid.resolution, fields["log_odds"], fields["hits"], grid.table, grid.corner)

    def dense(self) -> tuple[np.ndarray, SE2]:
        """Return the log-odds, shape (H, W), and the outer corner of cell (0, 0)."""
        values, corner = self._grid.dense("log_odds")
        x, y = (corner[::-1] * self._grid.resolution).tolist()
        return values, SE2(x, y, 0.0)

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._grid.num_bytes


@numba.njit(cache=True)
def count_hits(origins, angles, ranges, hits, table, corner):  # type: ignore[no-untyped-def]
    """Count where beams end, lengths in cells; see `trace_rays`."""
    for i in range(len(angles)):
        col = int(np.floor(origins[i, 0] + ranges[i] * np.cos(angles[i])))
        row = int(np.floor(origins[i, 1] + ranges[i] * np.sin(angles[i])))
        slot = find_slot(table, corner, row, col)
        r, c = row & TILE_MASK, col & TILE_MASK
        if slot >= 0 and hits[slot, r, c] < MAX_HITS:
            hits[slot, r, c] += 1


@numba.njit(cache=True, inline="always")
def at(cells, x, y):  # type: ignore[no-untyped-def]
    """Return the log-odds and the hits of the cell at a place, 0 where nothing is stored."""
    row, col = int(np.floor(y / cells.resolution)), int(np.floor(x / cells.resolution))
    slot = find_slot(cells.table, cells.corner, row, col)
    if slot < 0:
        return np.float32(0.0), np.uint8(0)
    r, c = row & TILE_MASK, col & TILE_MASK
    return cells.log_odds[slot, r, c], cells.hits[slot, r, c]
