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
known better later; steps 4 to 6 when a map is asked for (`bayes_moment`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.bayes_moment import BayesMoment
from grid_mapper.config import GridMapperConfig
from grid_mapper.echo_judging import judge
from grid_mapper.opaque_cells import OpaqueCells
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
        self._moment: BayesMoment | None = None

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Find panes by other values from now on; views are kept as they were."""
        self._config, self._moment = config, None

    def add_scan(self, scan: Scan, T_map_laser: SE2, stamp_ns: int) -> None:
        """Trace a scan's beams, and judge some views again."""
        self._moment = None
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
        self._moment = None
        self._fresh.append((stamp_ns, row))
        if len(self._fresh) > MAX_FRESH:
            self._fresh.popleft()

    def frozen(self, *_: Callable[[], OccupancyMap]) -> BayesMoment:
        """Return what is known now, for another thread to find panes in; maps are not needed."""
        if self._moment is None:
            rows = np.array([row for _, row in self._fresh], np.int64)
            self._moment = BayesMoment(
                self._config, self._views.used.copy(), rows, self._firsts(rows),
                self._opaque.frozen(),
            )  # fmt: skip
        return self._moment

    def panes(self) -> np.ndarray:
        """Return the stretches of glass found, as (x0, y0, x1, y1), shape (N, 4), m."""
        return self.frozen().panes()

    def glass(self) -> OccupancyMap:
        """Return the panes: occupied there, unknown elsewhere, over all that the laser saw."""
        return self.frozen().glass()

    def occupancy(self, laser_map: OccupancyMap) -> OccupancyMap:
        """Return the laser's map with the panes in it."""
        return self.frozen().occupancy(laser_map)

    @property
    def num_bytes(self) -> int:
        """Bytes held."""
        return self._views.num_bytes + self._opaque.num_bytes

    def _due(self, before_ns: int) -> list[int]:
        """Take the rows of the views that came before a stamp and were judged but once."""
        rows = []
        while self._fresh and self._fresh[0][0] <= before_ns:
            rows.append(self._fresh.popleft()[1])
        return rows

    def _judge(self, rows: list[int]) -> None:
        config = self._config.bayes
        judge(
            self._views.rows, np.array(rows), self._firsts(rows), config.explained_m,
            config.range_tolerance_m, config.range_tolerance_share, self._opaque.cells,
        )  # fmt: skip

    def _firsts(self, rows: Iterable[int]) -> np.ndarray:
        """Return where the neighbors of each row begin, shape (N, 9)."""
        return np.array([self._views.near(row) for row in rows], np.int64).reshape(-1, 9)
