"""The map of ultrasonic points of the glass paper, section 5.

An echo at r is a sector (Fig. 2): cells whose center lies between r - dr and r + dr, within the
cone, gain 1/r^2 points (eq. 1), the fewer the further, for a far echo is broad and often wrong.
Points of P_S and more make an obstacle. Points only grow: nothing is taken back.

The paper knows no free cells here. Beside the points a cell keeps whether a cone with an echo
behind it swept over it, so that a robot without laser has a map to drive in.
"""

from __future__ import annotations

from copy import copy

import numba
import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper.sonar_config import SonarConfig
from grid_mapper.sonar_reading import Free, Hit, classify, opening
from grid_mapper.tile_grid import NO_TILE, TILE_BITS, TILE_MASK, TileGrid, find_slot

ANGLE_SLACK = 1e-9
"""Of a cosine: a center on the cone's edge is inside whatever the rounding."""


class SonarGrid:
    """Points of every cell, and whether it was swept."""

    def __init__(self, config: SonarConfig, resolution: float) -> None:
        self.config = config
        self._grid = TileGrid(resolution, points=(np.float32, ()), is_swept=(np.bool_, ()))

    def add_range(self, reading: RangeReading, T_map_sonar: SE2) -> bool:
        """Sample one reading; False if it says nothing.

        Args:
            reading: As the driver sent it; see `classify`.
            T_map_sonar: Pose of the sonar, which looks along its x axis.
        """
        heard = classify(reading)
        if isinstance(heard, Hit):
            tolerance = self.config.range_tolerance_m
            near, far = heard.range - tolerance, heard.range + tolerance
            self._sample(reading, T_map_sonar, max(near, 0.0), far, points_of(heard.range))
            return True
        if isinstance(heard, Free) and self.config.no_echo_free_m > 0.0:
            far = min(heard.range, self.config.no_echo_free_m)
            self._sample(reading, T_map_sonar, np.inf, far, 0.0)
            return True
        return False

    def occupancy(self) -> OccupancyMap:
        """Return obstacles (points of P_S and more), what was swept as free, the rest unknown."""
        points, corner = self._grid.dense("points")
        is_swept, _ = self._grid.dense("is_swept")
        cells = np.where(is_swept, np.int8(FREE), np.int8(UNKNOWN))
        cells[points >= np.float32(self.config.min_points)] = OCCUPIED
        return OccupancyMap(cells, self._grid.resolution, self._origin(corner))

    def frozen(self) -> SonarGrid:
        """Return the grid as it stands, for another thread to read; see `TileGrid.frozen`."""
        there = copy(self)
        there._grid = self._grid.frozen()
        return there

    def points(self) -> tuple[np.ndarray, SE2]:
        """Return the points of all cells, shape (H, W), 1/m^2, and the corner of cell (0, 0)."""
        points, corner = self._grid.dense("points")
        return points, self._origin(corner)

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._grid.num_bytes

    def _origin(self, corner: np.ndarray) -> SE2:
        x, y = corner[::-1] * self._grid.resolution
        return SE2(float(x), float(y), 0.0)

    def _sample(
        self, reading: RangeReading, T_map_sonar: SE2, near: float, far: float, points: float
    ) -> None:
        """Add points from `near` to `far`, and sweep what is nearer than `near`; m."""
        grid, half_angle = self._grid, 0.5 * opening(reading, self.config)
        origin = np.array([T_map_sonar.x, T_map_sonar.y]) / grid.resolution
        near, far = near / grid.resolution, far / grid.resolution
        box = sector_box(origin, T_map_sonar.yaw, half_angle, far)
        grid.ensure_tiles(_missing_in_box(box, grid.table, grid.corner))
        sample_arc(
            origin, T_map_sonar.yaw, half_angle, near, far, box, np.float32(points),
            grid.fields["points"], grid.fields["is_swept"], grid.table, grid.corner,
        )  # fmt: skip


def points_of(r: float) -> float:
    """Return G = 1/r^2 (eq. 1), 1/m^2; the paper counts r in mm."""
    return 1.0 / (r * r)


@numba.njit(cache=True)
def sector_box(origin, yaw, half_angle, far):  # type: ignore[no-untyped-def]
    """Return (first row, first col, last row, last col) of the cells a sector touches, int64.

    Args:
        origin: (x, y) of the sensor, shape (2,), cells.
        yaw: Direction of the sector's middle, rad.
        half_angle: Half its opening, rad.
        far: Its radius, cells.
    """
    x0, y0, x1, y1 = origin[0], origin[1], origin[0], origin[1]
    for k in range(6):  # both edges, then the axes that lie between them
        angle = yaw + (half_angle if k else -half_angle) if k < 2 else (k - 2) * 0.5 * np.pi
        if k >= 2 and np.cos(angle - yaw) < np.cos(half_angle):
            continue
        x, y = origin[0] + far * np.cos(angle), origin[1] + far * np.sin(angle)
        x0, y0, x1, y1 = min(x0, x), min(y0, y), max(x1, x), max(y1, y)
    box = np.empty(4, np.int64)
    box[0], box[1] = np.floor(y0), np.floor(x0)
    box[2], box[3] = np.floor(y1), np.floor(x1)
    return box


@numba.njit(cache=True)
def _missing_in_box(box, table, corner):  # type: ignore[no-untyped-def]
    """Return the tiles of a box that `table` has not, shape (N, 2)."""
    row0, col0, row1, col1 = box >> TILE_BITS
    tiles = np.empty(((row1 - row0 + 1) * (col1 - col0 + 1), 2), np.int64)
    num = 0
    for row in range(row0, row1 + 1):
        for col in range(col0, col1 + 1):
            if find_slot(table, corner, row << TILE_BITS, col << TILE_BITS) == NO_TILE:
                tiles[num, 0], tiles[num, 1] = row, col
                num += 1
    return tiles[:num]


@numba.njit(cache=True)
def sample_arc(  # type: ignore[no-untyped-def]
    origin, yaw, half_angle, near, far, box, gain, points, is_swept, table, corner
):
    """Add `gain` to the cells of an arc and sweep those before it (Fig. 2); lengths in cells.

    Args:
        origin: (x, y) of the sonar, shape (2,), cells.
        yaw: Where it looks, rad.
        half_angle: alpha_S / 2, at most pi / 2, rad.
        near: Inner radius of the arc; infinite where there was no echo.
        far: Outer radius.
        box: See `sector_box`.
        gain: G of eq. 1.
        points: Pool, changed in place.
        is_swept: Pool, changed in place.
        table: See TileGrid.
        corner: See TileGrid.
    """
    ux, uy, least_cos = np.cos(yaw), np.sin(yaw), np.cos(half_angle) - ANGLE_SLACK
    for row in range(box[0], box[2] + 1):
        dy = row + 0.5 - origin[1]
        for col in range(box[1], box[3] + 1):
            dx = col + 0.5 - origin[0]
            distance = np.sqrt(dx * dx + dy * dy)
            if distance > far or dx * ux + dy * uy < least_cos * distance:
                continue
            slot = find_slot(table, corner, row, col)
            r, c = row & TILE_MASK, col & TILE_MASK
            if distance < near:
                is_swept[slot, r, c] = True
            else:
                points[slot, r, c] += gain
