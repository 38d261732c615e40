"""The laser label grid of the glass paper, section 4: unknown, free, occupied, with points.

Every beam is a sector (Fig. 1): cells whose centre lies nearer than r - dr are free; those between
r - dr and r + dr are occupied and gain a point. An occupied cell never turns free while sampling.
Cells with few points are noise candidates; they are judged when the map is asked for (4.2), from
all points so far, so that the map can be asked for again and again while scans arrive.
"""

from __future__ import annotations

from copy import copy

import cv2
import numba
import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.beams import Beams, beams_of
from grid_mapper.config import LabelGridConfig
from grid_mapper.tile_grid import NOWHERE, SIDE_CELLS, TILE_BITS, TILE_MASK, TileGrid, find_slot

LABEL_UNKNOWN, LABEL_FREE, LABEL_OCCUPIED = 0, 1, 2
MAX_POINTS = np.iinfo(np.uint16).max
MAX_HALF_ANGLE = 0.25 * np.pi  # a wider sector has edges on both sides of a diagonal
RAY_CELLS = SIDE_CELLS  # what `missing_on_rays` leaves beside a ray, for sectors
MIN_COS = 1e-12


class LabelGrid:
    """Labels and points of every cell seen."""

    def __init__(self, config: LabelGridConfig, resolution: float) -> None:
        self.config = config
        self._grid = TileGrid(resolution, labels=(np.int8, ()), points=(np.uint16, ()))

    def add_scan(self, scan: Scan, T_map_laser: SE2) -> None:
        """Sample one scan (4.1)."""
        self.add_beams(beams_of(scan, T_map_laser, self.config.no_return_free_m))

    def add_beams(self, beams: Beams) -> None:
        """Sample beams given in the map frame (4.1).

        Raises:
            ValueError: If the sectors would open by pi / 2 or more.
        """
        grid = self._grid
        half_angle = self._half_angle(beams)
        origins, ranges = beams.origins / grid.resolution, beams.ranges / grid.resolution
        tolerance = self.config.range_tolerance_m / grid.resolution
        grid.ensure_rays(*sector_rays(origins, beams.angles, ranges + tolerance, half_angle))
        sample_sectors(
            origins, beams.angles, ranges, beams.is_hit, half_angle, tolerance,
            grid.fields["labels"], grid.fields["points"], grid.table, grid.corner,
        )  # fmt: skip

    def begin_with(self, cells: np.ndarray, values: np.ndarray) -> None:
        """Take cells (row, col), shape (N, 2), that are known: FREE or OCCUPIED, no noise."""
        is_occupied = values == OCCUPIED
        labels = np.where(is_occupied, LABEL_OCCUPIED, LABEL_FREE)
        self._grid.write("labels", cells, labels.astype(np.int8))
        points = np.where(is_occupied, self.config.noise_points + 1, 0)
        self._grid.write("points", cells, points.astype(np.uint16))

    def occupancy(self) -> OccupancyMap:
        """Return the map with noise candidates judged (4.2)."""
        labels, corner = self._grid.dense("labels")
        points, _ = self._grid.dense("points")
        judged = remove_noise(
            labels, points, self.config.noise_points, self._border_cells(), self.config.hole_cells
        )
        resolution = self._grid.resolution
        cells = np.take(np.array([UNKNOWN, FREE, OCCUPIED], np.int8), judged)
        origin = SE2(float(corner[1] * resolution), float(corner[0] * resolution), 0.0)
        return OccupancyMap(cells, resolution, origin)

    def frozen(self) -> LabelGrid:
        """Return the grid as it stands, for another thread to read; see `TileGrid.frozen`."""
        there = copy(self)
        there._grid = self._grid.frozen()
        return there

    def _half_angle(self, beams: Beams) -> float:
        """Return alpha_L / 2."""
        given, increment = self.config.beam_angle_rad, beams.angle_increment
        half_angle = 0.5 * (given if given > 0.0 else increment)
        if not 0.0 <= half_angle < MAX_HALF_ANGLE:
            raise ValueError(
                f"half the opening of a beam must be in [0, {MAX_HALF_ANGLE:.4f}) rad, got "
                f"{half_angle:.4f} (beam_angle_rad {given}, angle_increment {increment:.4f}): "
                "set beam_angle_rad to what a beam of this sensor opens by"
            )
        return half_angle

    def _border_cells(self) -> int:
        """Return how thick a wall is sampled, in cells: 2 dr."""
        return max(1, round(2.0 * self.config.range_tolerance_m / self._grid.resolution))

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._grid.num_bytes


def sector_rays(
    origins: np.ndarray, angles: np.ndarray, lengths: np.ndarray, half_angle: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return rays (origins, angles, lengths): no point of a sector is `RAY_CELLS` from all."""
    if not len(lengths) or half_angle * lengths.max() <= RAY_CELLS:
        return origins, angles, lengths
    num = np.maximum(1, np.ceil(lengths * (half_angle / RAY_CELLS))).astype(np.int64)
    first = np.repeat(np.cumsum(num) - num, num)
    share = (2.0 * (np.arange(num.sum()) - first) + 1.0) / np.repeat(num, num) - 1.0
    angles = np.repeat(angles, num) + half_angle * share
    return np.repeat(origins, num, axis=0), angles, np.repeat(lengths, num)


def remove_noise(
    labels: np.ndarray, points: np.ndarray, noise_points: int, border_cells: int, hole_cells: int
) -> np.ndarray:
    """Judge cells of few points (4.2): obstacle on the border of the known, else free.

    Args:
        labels: 0 unknown, 1 free, 2 occupied, shape (H, W), int8.
        points: Times each cell was sampled occupied, shape (H, W).
        noise_points: P_L; occupied cells with at most this many points are noise candidates.
        border_cells: How far, in cells, the border between unknown and free reaches: as thick
            as a wall is sampled, so that its near and its far cells both count.
        hole_cells: Unknown regions of fewer cells make no border; 0 if every unknown cell does.

    Returns:
        Labels of the judged map, shape (H, W), int8. The input is not modified.
    """
    candidate = (labels == LABEL_OCCUPIED) & (points <= noise_points)
    if not candidate.any():
        return labels.copy()
    kernel = np.ones((2 * border_cells + 1, 2 * border_cells + 1), np.uint8)
    k = border_cells  # what lies outside the array is unknown too
    unknown = np.pad((labels == LABEL_UNKNOWN).astype(np.uint8), k, constant_values=1)
    near_unknown = cv2.dilate(_without_holes(unknown, hole_cells), kernel)[k:-k, k:-k]
    near_free = cv2.dilate((labels == LABEL_FREE).astype(np.uint8), kernel)
    on_border = (near_unknown > 0) & (near_free > 0)
    judged = labels.copy()
    judged[candidate & ~on_border] = LABEL_FREE
    return judged


def _without_holes(unknown: np.ndarray, hole_cells: int) -> np.ndarray:
    """Return a mask (0, 1) without its small regions; that of cell (0, 0), the outside, stays.

    Cells of one region share edges: the gaps that beams leave between them touch at corners only.
    """
    if hole_cells <= 1:
        return unknown
    _, regions, stats, _ = cv2.connectedComponentsWithStats(unknown, connectivity=4)
    is_kept = (stats[:, cv2.CC_STAT_AREA] >= hole_cells).astype(np.uint8)
    is_kept[0], is_kept[regions[0, 0]] = 0, 1  # 0 is what is known
    return is_kept[regions]


@numba.njit(cache=True)
def sample_sectors(  # type: ignore[no-untyped-def]
    origins, angles, ranges, is_hit, half_angle, tolerance, labels, points, table, corner
):
    """Label the cells of every beam's sector (glass paper, 4.1 and Fig. 1); lengths are in cells.

    Args:
        origins: (x, y) of the sensor at each beam, shape (N, 2), cells.
        angles: Of the beams, map frame, shape (N,), rad.
        ranges: Measured, or free length where nothing was hit, shape (N,), cells.
        is_hit: False for beams that only say free, shape (N,).
        half_angle: Half of a sector's opening, alpha_L / 2, in (0, pi/4), rad.
        tolerance: dr_L, cells.
        labels: Pool, changed in place.
        points: Pool, changed in place.
        table: See TileGrid.
        corner: See TileGrid.
    """
    for i in range(len(angles)):
        depth = tolerance if is_hit[i] else 0.0
        near, far = max(ranges[i] - depth, 0.0), ranges[i] + depth
        if not is_hit[i]:
            near = np.inf
        # u is the axis the beam runs along, v the other; centres of cells are whole numbers
        is_flat = abs(np.cos(angles[i])) >= abs(np.sin(angles[i]))
        x, y = origins[i, 0], origins[i, 1]
        ou, ov = (x, y) if is_flat else (y, x)
        angle = angles[i] if is_flat else 0.5 * np.pi - angles[i]
        _sample_sector(
            ou - 0.5, ov - 0.5, is_flat, angle, half_angle, near * near, far,
            labels, points, table, corner,
        )  # fmt: skip


@numba.njit(cache=True, inline="always")
def _sample_sector(  # type: ignore[no-untyped-def]
    ou, ov, is_flat, angle, half_angle, near2, far, labels, points, table, corner
):
    """Walk the sector along u; on each line the centres between its two edges are inside."""
    cos_a, cos_b = np.cos(angle - half_angle), np.cos(angle + half_angle)
    side = 1 if cos_a + cos_b > 0.0 else -1
    # both have the sign of `side`; an edge along v would be 0 up to rounding
    cos_a, cos_b = side * max(side * cos_a, MIN_COS), side * max(side * cos_b, MIN_COS)
    slope_a, slope_b = np.sin(angle - half_angle) / cos_a, np.sin(angle + half_angle) / cos_b
    low, high = min(slope_a * side, slope_b * side), max(slope_a * side, slope_b * side)
    u_reach = far if low < 0.0 < high else far * max(abs(cos_a), abs(cos_b))
    first = int(np.ceil(ou)) if side > 0 else int(np.floor(ou))
    start = abs(first - ou)
    tile_row, tile_col, slot = NOWHERE, NOWHERE, -1
    tile_labels, tile_points = labels[0], points[0]
    for k in range(int(np.floor(u_reach - start)) + 1):
        u, du = first + side * k, start + k
        v_low, v_high = ov + max(du * low, -far), ov + min(du * high, far)
        for v in range(int(np.ceil(v_low)), int(np.floor(v_high)) + 1):
            distance2 = du * du + (v - ov) * (v - ov)
            if distance2 > far * far:
                continue
            row, col = (v, u) if is_flat else (u, v)
            if row >> TILE_BITS != tile_row or col >> TILE_BITS != tile_col:
                tile_row, tile_col = row >> TILE_BITS, col >> TILE_BITS
                slot = find_slot(table, corner, row, col)
                if slot >= 0:
                    tile_labels, tile_points = labels[slot], points[slot]
            if slot < 0:
                continue
            r, c = row & TILE_MASK, col & TILE_MASK
            if distance2 < near2:
                if tile_labels[r, c] == LABEL_UNKNOWN:
                    tile_labels[r, c] = LABEL_FREE
            else:
                tile_labels[r, c] = LABEL_OCCUPIED
                if tile_points[r, c] < MAX_POINTS:
                    tile_points[r, c] += 1
