"""Panes found in what laser and sonars told so far: steps 4 to 6 of `bayes_fusion`.

A moment holds a copy of the views, so that panes can be searched in another thread while readings
go on coming in.
"""

from __future__ import annotations

import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from grid_mapper.config import GridMapperConfig
from grid_mapper.echo_judging import judge_aside
from grid_mapper.opaque_cells import OpaqueCells
from grid_mapper.pane_lines import PaneLine, find_lines
from grid_mapper.pane_stretches import stretches
from grid_mapper.post_rows import post_rows


class BayesMoment:
    """What was known when it was made, and the panes in that.

    Args:
        config: Its `bayes` and `resolution_m` are used.
        views: All views; judged anew here.
        fresh: Rows of those that were judged but once, shape (N,).
        firsts: For each the cells to look in, see `SonarViews.near`, shape (N, 9).
        opaque: The laser's cells.
    """

    def __init__(
        self, config: GridMapperConfig, views: np.ndarray, fresh: np.ndarray,
        firsts: np.ndarray, opaque: OpaqueCells,
    ) -> None:  # fmt: skip
        self._config = config
        self._views, self._fresh, self._firsts = views, fresh, firsts
        self._opaque = opaque
        self._found: tuple[np.ndarray, np.ndarray] | None = None

    def panes(self) -> np.ndarray:
        """Return the stretches of glass found, as (x0, y0, x1, y1), shape (N, 4), m."""
        return self._all_found()[0]

    def in_doubt(self) -> np.ndarray:
        """Return the stretches that may be glass as well as open, shape (N, 4), m."""
        return self._all_found()[1]

    def glass(self) -> OccupancyMap:
        """Return the panes: occupied there, unknown elsewhere, over all that the laser saw."""
        values, origin = self._opaque.dense()
        cells = np.full(values.shape, UNKNOWN, np.int8)
        empty = OccupancyMap(cells, self._config.resolution_m, origin)
        is_pane = on_panes(empty, self.panes(), self._config.bayes.half_thickness_m)
        cells[is_pane & (values <= 0.0)] = OCCUPIED
        return OccupancyMap(cells, empty.resolution, origin)

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the laser's map with the panes in it; what is in doubt is not free."""
        cells, half = laser_map.cells.copy(), self._config.bayes.half_thickness_m
        cells[on_panes(laser_map, self.in_doubt(), half) & (cells == FREE)] = UNKNOWN
        cells[on_panes(laser_map, self.panes(), half)] = OCCUPIED
        return OccupancyMap(cells, laser_map.resolution, laser_map.origin)

    def _all_found(self) -> tuple[np.ndarray, np.ndarray]:
        if self._found is None:
            self._found = self._find()
        return self._found

    def _find(self) -> tuple[np.ndarray, np.ndarray]:
        config, views = self._config.bayes, self._views
        judge_aside(
            views, self._fresh, self._firsts, config.explained_m, config.range_tolerance_m,
            config.range_tolerance_share, self._opaque.cells,
        )  # fmt: skip
        panes: list[np.ndarray] = []
        doubts: list[np.ndarray] = []
        for line in sorted(find_lines(views, config), key=lambda p: p.range):
            if not self._is_heard_through(line, panes):
                found = stretches(line, views, config, self._opaque.cells)
                panes += _segments(line, found.glass)
                doubts += _segments(line, found.in_doubt)
        for row in post_rows(*self._opaque.dense(), self._config.resolution_m, config.max_bay_m):
            found = stretches(row, views, config, self._opaque.cells)
            doubts += _segments(row, found.in_doubt)
        return np.array(panes).reshape(-1, 4), np.array(doubts).reshape(-1, 4)

    def _is_heard_through(self, line: PaneLine, panes: list[np.ndarray]) -> bool:
        """Tell whether most echoes of a line came from behind panes nearer than it."""
        if not panes:
            return False
        views = self._views[line.echoes]
        places = np.column_stack((views["x"], views["y"]))
        n = np.array([np.cos(line.theta), np.sin(line.theta)])
        feet = places + (line.rho - places @ n)[:, None] * n
        share = (views["r"] - 0.15) / views["r"]
        ends = places + np.maximum(share, 0.0)[:, None] * (feet - places)
        is_behind = np.zeros(len(views), bool)
        for x0, y0, x1, y1 in panes:
            is_behind |= _cross(places, ends, np.array([x0, y0]), np.array([x1, y1]))
        return bool(is_behind.mean() > 0.5)


def _segments(line: PaneLine, ends: np.ndarray) -> list[np.ndarray]:
    """Return stretches of a line, each as (x0, y0, x1, y1)."""
    foot = line.rho * np.array([np.cos(line.theta), np.sin(line.theta)])
    way = np.array([-np.sin(line.theta), np.cos(line.theta)])
    return [np.concatenate((foot + a * way, foot + b * way)) for a, b in ends]


def _cross(a: np.ndarray, b: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return which ways from a (N, 2) to b (N, 2) cross the one from p to q."""

    def side(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        d, e = v - u, w - u
        return np.asarray(d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0])

    return np.asarray(
        ((side(p, q, a) > 0.0) != (side(p, q, b) > 0.0))
        & ((side(a, b, p[None]) > 0.0) != (side(a, b, q[None]) > 0.0))
    )


def on_panes(like: OccupancyMap, panes: np.ndarray, half_thickness: float) -> np.ndarray:
    """Return which cells of a map have their centers on panes (N, 4), shape of the map."""
    is_on = np.zeros(like.cells.shape, bool)
    for x0, y0, x1, y1 in panes:
        local = like.origin.inverse() @ np.array([[x0, y0], [x1, y1]])
        low = np.floor((local.min(axis=0) - half_thickness) / like.resolution).astype(int)
        high = np.ceil((local.max(axis=0) + half_thickness) / like.resolution).astype(int)
        (c0, r0), (c1, r1) = np.maximum(low, 0), np.minimum(high, like.cells.shape[::-1])
        if c1 <= c0 or r1 <= r0:
            continue
        xs, ys = np.meshgrid(np.arange(c0, c1) + 0.5, np.arange(r0, r1) + 0.5)
        offset = np.stack((xs, ys), axis=-1) * like.resolution - local[0]
        way = local[1] - local[0]
        length = float(np.hypot(*way))
        way = way / max(length, 1e-9)
        along = offset @ way
        across = np.abs(offset[..., 0] * way[1] - offset[..., 1] * way[0])
        is_on[r0:r1, c0:c1] |= (across <= half_thickness) & (along >= 0.0) & (along <= length)
    return is_on
