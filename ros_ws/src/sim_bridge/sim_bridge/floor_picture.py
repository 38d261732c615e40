"""A floor's picture: carpet, painted areas, lines and rings, dirt."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from sim_bridge.appearance import Color, Floor, Line, Ring
from sim_bridge.textures import noise


def floor_picture(floor: Floor) -> np.ndarray | None:
    """Return the picture of a floor, RGB uint8, rows along +y from `from_m`; None without area.

    Edges are painted with the share of a texel that they cover, so that they lie where the file
    says to a small part of a texel. The last floors are kept: worlds of one floor begin sooner.
    """
    painted = _painted(floor)
    return None if painted is None else painted.copy()


@lru_cache(maxsize=4)
def _painted(floor: Floor) -> np.ndarray | None:
    columns, rows = (
        round((b - a) / floor.texel_m) for a, b in zip(floor.from_m, floor.to_m, strict=True)
    )
    if rows <= 0 or columns <= 0:
        return None
    canvas = _Canvas(floor, rows, columns)
    for area in floor.areas:
        canvas.paint_area(area.from_m, area.to_m, area.color)
    for line in floor.lines:
        canvas.paint_line(line)
    for ring in floor.rings:
        canvas.paint_ring(ring)
    canvas.paint_dirt(floor)
    rng = np.random.default_rng(floor.dirt.seed)
    carpet = 0.8 * noise(rng, (rows, columns), 2) + 0.6 * noise(rng, (rows, columns), 24)
    shaded = canvas.pixels * (1.0 + floor.carpet * carpet)[:, :, None]
    return np.clip(np.rint(255.0 * shaded), 0, 255).astype(np.uint8)


class _Canvas:
    """Float pixels with the world places of their middles."""

    def __init__(self, floor: Floor, rows: int, columns: int) -> None:
        self.pixels = np.empty((rows, columns, 3), dtype=np.float32)
        self.pixels[:] = floor.color
        self._texel = floor.texel_m
        self._x = (floor.from_m[0] + (np.arange(columns) + 0.5) * self._texel)[None, :]
        self._y = (floor.from_m[1] + (np.arange(rows) + 0.5) * self._texel)[:, None]

    def paint_area(self, low: tuple[float, float], high: tuple[float, float], color: Color) -> None:
        covered = self._inside(low[0] - self._x) * self._inside(self._x - high[0])
        self._blend(
            covered * self._inside(low[1] - self._y) * self._inside(self._y - high[1]), color
        )

    def paint_line(self, line: Line) -> None:
        (x0, y0), (x1, y1) = line.from_m, line.to_m
        length = math.hypot(x1 - x0, y1 - y0)
        c, s = (x1 - x0) / length, (y1 - y0) / length
        along = c * (self._x - x0) + s * (self._y - y0)
        across = np.abs(c * (self._y - y0) - s * (self._x - x0))
        ends = self._inside(-along) * self._inside(along - length)
        self._blend(self._inside(across - line.width_m / 2.0) * ends, line.color)

    def paint_ring(self, ring: Ring) -> None:
        distance = np.hypot(self._x - ring.center_m[0], self._y - ring.center_m[1])
        self._blend(self._inside(np.abs(distance - ring.radius_m) - ring.width_m / 2.0), ring.color)

    def paint_dirt(self, floor: Floor) -> None:
        rng = np.random.default_rng([floor.dirt.seed, 1])
        for _ in range(floor.dirt.count):
            x, y = rng.uniform(floor.from_m, floor.to_m)
            radius = floor.dirt.size_m * rng.uniform(0.2, 0.7)
            stretch, turn = rng.uniform(0.4, 1.0), rng.uniform(0.0, math.pi)
            reach = radius + 2.0 * self._texel
            j = np.flatnonzero(np.abs(self._x[0] - x) < reach)
            i = np.flatnonzero(np.abs(self._y[:, 0] - y) < reach)
            if len(i) and len(j):
                window = np.ix_(i, j)
                dx, dy = self._x[0, j][None, :] - x, self._y[i, 0][:, None] - y
                c, s = math.cos(turn), math.sin(turn)
                distance = np.hypot(c * dx + s * dy, (c * dy - s * dx) / stretch)
                share = 0.8 * self._inside(distance - radius)[:, :, None]
                old = self.pixels[window]
                self.pixels[window] = old + share * (np.array(floor.dirt.color) - old)

    def _inside(self, beyond: np.ndarray) -> np.ndarray:
        """Return the share of a texel inside an edge, from its middle's distance beyond it."""
        return np.clip(0.5 - beyond / self._texel, 0.0, 1.0)

    def _blend(self, share: np.ndarray, color: Color) -> None:
        self.pixels += share[:, :, None].astype(np.float32) * (
            np.array(color, dtype=np.float32) - self.pixels
        )
