"""Glass from laser and sonars together, integrated over time: `fusion: bayes`.

Beyond the glass paper, which names as future work that laser data remove the sonars' noise and that
measurements be integrated by Bayes' rule. Step by step:

1. Laser scans give each cell log-odds of being opaque (`log_odds.trace_rays`). Glass, which sends
   back only the beams along its normal, is crossed far more often than hit.
2. Readings of sonars are kept as views (`sonar_views`): the newest word from each place.
3. An echo is judged against the laser's cells and its neighbors (`echo_judging`): explained by
   something opaque, come by mirrors from behind it, or on a line with others.
4. Lines are fitted to what is left (`pane_lines`), the nearest first: what is heard through a pane
   came by mirrors.
5. Along each line log-odds tell glass from openings, and posts and walls are joined to it
   (`pane_stretches`).
6. Cells on the stretches are occupied.

Steps 1 to 3 are done as data come, with views judged again in turn, for laser and neighbors are
known better later; steps 4 to 6 when a map is asked for.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.echo_judging import judge
from grid_mapper.opaque_cells import OpaqueCells
from grid_mapper.pane_lines import PaneLine, find_lines
from grid_mapper.pane_stretches import stretches
from grid_mapper.sonar_reading import Hit, Nothing, classify, opening
from grid_mapper.sonar_views import SonarViews

JUDGED_PER_SCAN = 40
"""Views judged anew at each scan, in turn."""
MAX_FRESH = 2000
SOON_NS = 2_000_000_000
"""A view is judged anew so long after it was taken too: the laser has seen the place at a slant."""


class BayesFusion:
    """Panes found by laser and sonars."""

    def __init__(self, config: GridMapperConfig) -> None:
        self._config = config
        bayes = config.bayes
        self._views = SonarViews(bayes.view_m, bayes.view_rad, bayes.max_views)
        self._opaque = OpaqueCells(config.resolution_m)
        self._turn = 0
        self._fresh: deque[tuple[int, int]] = deque()
        self._panes: np.ndarray | None = None

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Find panes by other values from now on; views are kept as they were."""
        self._config, self._panes = config, None

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int) -> None:
        """Trace a scan's beams, and judge some views again."""
        self._panes = None
        self._opaque.add_scan(scan, T_map_laser, stamp_ns, self._config.log_odds)
        rows = self._due(stamp_ns - SOON_NS)
        if self._views.num:
            num = min(JUDGED_PER_SCAN, self._views.num)
            rows += ((self._turn + np.arange(num)) % self._views.num).tolist()
            self._turn = (self._turn + num) % self._views.num
            self._judge(rows)

    def add_range(self, reading: RangeReading, T_map_sonar: SE2, stamp_ns: int) -> None:
        """Take a reading into the view that it belongs to, and judge that.

        A fixed-distance ranger says that something is nearer than its distance, not where: no line
        can be fitted to that, and it is left out.
        """
        heard = classify(reading)
        if isinstance(heard, Nothing) or reading.min_range == reading.max_range:
            return
        is_echo, r = isinstance(heard, Hit), heard.range
        if not math.isfinite(r):
            return
        half = 0.5 * opening(reading, self._config.sonar)
        most = self._config.bayes.max_repeats
        row = self._views.add(T_map_sonar, half, r, is_echo, stamp_ns, most)
        self._judge([row])
        self._panes = None
        self._fresh.append((stamp_ns, row))
        if len(self._fresh) > MAX_FRESH:
            self._fresh.popleft()

    def panes(self) -> np.ndarray:
        """Return the stretches of glass found, as (x0, y0, x1, y1), shape (N, 4), m."""
        if self._panes is None:
            self._panes = self._find_panes()
        return self._panes

    def _find_panes(self) -> np.ndarray:
        if self._fresh:
            self._judge([row for _, row in self._fresh])
        found: list[np.ndarray] = []
        for line in sorted(find_lines(self._views.used, self._config.bayes), key=lambda p: p.range):
            if self._is_heard_through(line, found):
                continue
            ends = stretches(line, self._views.used, self._config.bayes, self._opaque.cells)
            foot = line.rho * np.array([np.cos(line.theta), np.sin(line.theta)])
            way = np.array([-np.sin(line.theta), np.cos(line.theta)])
            found += [np.concatenate((foot + a * way, foot + b * way)) for a, b in ends]
        return np.array(found).reshape(-1, 4)

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._views.num_bytes + self._opaque.num_bytes

    def _is_heard_through(self, line: PaneLine, panes: list[np.ndarray]) -> bool:
        """Tell whether most echoes of a line came from behind panes nearer than it."""
        if not panes:
            return False
        views = self._views.used[line.echoes]
        places = np.column_stack((views["x"], views["y"]))
        n = np.array([np.cos(line.theta), np.sin(line.theta)])
        feet = places + (line.rho - places @ n)[:, None] * n
        share = (views["r"] - 0.15) / views["r"]
        ends = places + np.maximum(share, 0.0)[:, None] * (feet - places)
        is_behind = np.zeros(len(views), bool)
        for x0, y0, x1, y1 in panes:
            is_behind |= _cross(places, ends, np.array([x0, y0]), np.array([x1, y1]))
        return bool(is_behind.mean() > 0.5)

    def _due(self, before_ns: int) -> list[int]:
        """Take the rows of the views that came before a stamp and were judged but once."""
        rows = []
        while self._fresh and self._fresh[0][0] <= before_ns:
            rows.append(self._fresh.popleft()[1])
        return rows

    def _judge(self, rows: list[int]) -> None:
        config = self._config.bayes
        firsts = np.array([self._views.near(row) for row in rows])
        judge(
            self._views.rows, np.array(rows), firsts, config.explained_m, config.range_tolerance_m,
            config.range_tolerance_share, self._opaque.cells,
        )  # fmt: skip

    def glass(self) -> OccupancyMap:
        """Return the panes: occupied there, unknown elsewhere, over all that the laser saw."""
        values, origin = self._opaque.dense()
        cells = np.full(values.shape, UNKNOWN, np.int8)
        empty = OccupancyMap(cells, self._config.resolution_m, origin)
        is_pane = on_panes(empty, self.panes(), self._config.bayes.half_thickness_m)
        cells[is_pane & (values <= 0.0)] = OCCUPIED
        return OccupancyMap(cells, empty.resolution, origin)

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the laser's map with the panes in it."""
        cells = laser_map.cells.copy()
        cells[on_panes(laser_map, self.panes(), self._config.bayes.half_thickness_m)] = OCCUPIED
        return OccupancyMap(cells, laser_map.resolution, laser_map.origin)


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
