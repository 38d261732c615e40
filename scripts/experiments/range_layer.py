"""The usual costmap layer for sonars, re-made as a baseline: a probabilistic cone, max combination.

It does what ROS's range_sensor_layer does: each cell keeps a probability; a reading
raises it about its arc, most on the cone's axis, and lowers it before; far arcs and the cone's
sides count less. Above `mark` a cell is lethal, below `clear` free, else the layer says nothing;
of the layer and the laser's map the higher value stands. Defaults are that layer's, whose cells
hold a byte each: a probability stays within 1/254 and 253/254 here, so that none sticks at 0 or 1.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper.overlay import on_cells_of
from grid_mapper.sonar_reading import Hit, classify

PHI_M = 1.2  # range at which trust has fallen to half
MARK, CLEAR = 0.8, 0.2
DEVIATION_SHARE = 0.05  # half width of the arc, in shares of the range
LEAST_P = 1.0 / 254.0


class RangeLayer:
    """Probabilities on the cells of a map.

    Args:
        like: Says where the cells are; readings outside are left out.
    """

    def __init__(self, like: OccupancyMap) -> None:
        self._like = like
        self._p = np.full(like.cells.shape, 0.5)

    def add_range(self, reading: RangeReading, T_map_sonar: SE2) -> None:
        """Take one reading; without an echo the layer changes nothing, as is its default."""
        heard = classify(reading)
        if isinstance(heard, Hit):
            T = self._like.origin.inverse() @ T_map_sonar
            half = 0.5 * reading.field_of_view
            _update(self._p, T.x, T.y, T.yaw, heard.range, half, self._like.resolution)

    def cells(self) -> np.ndarray:
        """Return 100 where marked, 0 where cleared, -1 elsewhere, shape (H, W), int8."""
        cells = np.full(self._p.shape, UNKNOWN, np.int8)
        cells[self._p < CLEAR] = FREE
        cells[self._p > MARK] = OCCUPIED
        return cells

    def combined(self, laser: OccupancyMap) -> OccupancyMap:
        """Return the higher of layer and laser's map in each cell, on this layer's cells."""
        cells = np.maximum(on_cells_of(laser, self._like), self.cells())
        return OccupancyMap(cells, self._like.resolution, self._like.origin)


@numba.njit(cache=True)
def sensor_probability(r, phi, theta, half):  # type: ignore[no-untyped-def]
    """Return the probability that a cell is occupied, given one echo.

    Args:
        r: Range of the echo, m.
        phi: Distance of the cell, m.
        theta: Bearing of the cell off the axis, rad.
        half: Half the cone's opening, rad.
    """
    near = 1.0 - (1.0 + math.tanh(2.0 * (phi - PHI_M))) / 2.0
    side = 1.0 - (theta / half) ** 2 if abs(theta) < half else 0.0
    trust, width = near * side, DEVIATION_SHARE * r
    low = 0.5 * (1.0 - trust)
    if phi < r - 2.0 * width:
        return low
    if phi < r - width:
        return low + 0.5 * trust * ((phi - (r - 2.0 * width)) / width) ** 2
    if phi < r + width:
        return 0.5 + trust * (0.5 - 0.5 * ((r - phi) / width) ** 2)
    return 0.5


@numba.njit(cache=True)
def _update(p, x, y, yaw, r, half, resolution):  # type: ignore[no-untyped-def]
    """Update all cells of a cone by Bayes' rule; lengths in m from the corner of the array."""
    far = r * (1.0 + DEVIATION_SHARE)
    row0 = max(int(math.floor((y - far) / resolution)), 0)
    row1 = min(int(math.floor((y + far) / resolution)), p.shape[0] - 1)
    col0 = max(int(math.floor((x - far) / resolution)), 0)
    col1 = min(int(math.floor((x + far) / resolution)), p.shape[1] - 1)
    c, s = math.cos(yaw), math.sin(yaw)
    for row in range(row0, row1 + 1):
        for col in range(col0, col1 + 1):
            dx, dy = (col + 0.5) * resolution - x, (row + 0.5) * resolution - y
            phi = math.hypot(dx, dy)
            if phi > far or c * dx + s * dy < phi * math.cos(half):
                continue
            theta = math.atan2(c * dy - s * dx, c * dx + s * dy)
            if abs(theta) >= half:
                continue
            q, prior = sensor_probability(r, phi, theta, half), p[row, col]
            after = q * prior / (q * prior + (1.0 - q) * (1.0 - prior))
            p[row, col] = min(max(after, LEAST_P), 1.0 - LEAST_P)
