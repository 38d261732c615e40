"""Time to enter a scan in the map, beside a plain numba ray trace of the same beams.

The peer walks the same beams over one dense float array, adds and clamps, and does nothing else:
no growing, no placing of beams. Floor: one pass over a 400 x 400 grid that adds one to every cell.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numba
import numpy as np

from experiments.bench_scan_matching import BEAMS
from experiments.corridor_loop import corridor_loop, slipping_odometry
from experiments.timing import Case, median_and_p99, take_turns
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.beams import beams_of
from grid_mapper.config import GridMapperConfig, LabelGridConfig, LogOddsConfig
from grid_mapper.label_grid import LabelGrid
from grid_mapper.log_odds import LogOddsGrid
from grid_mapper.mapper import GridMapper

RESOLUTION_M = 0.05
NUM_SCANS = 200
DENSE_CELLS = 1000  # 50 x 50 m
NO_RETURN_M = 5.0
NUM_LIVE_SCANS = 2000
LIVE_PERIOD_NS = 25_000_000


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each rule and number of beams."""
    cases = []
    for beams, (num_beams, fov) in BEAMS.items():
        say(f"map_update: {beams} beams")
        drive = corridor_loop(num_beams, fov, seed)
        ms = _race(list(zip(drive.scans, drive.truth, strict=True))[:NUM_SCANS])
        peer, floor = (float(np.median(ms[name])) for name in ("plain", "floor"))
        for rule in ("label", "log_odds"):
            median, p99 = median_and_p99(ms[rule])
            cases.append(Case(f"{rule}_{beams}", median, p99, "plain ray trace", peer, floor))
    return [*cases, *_whole(seed, say)]


def _whole(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Time all that a scan costs at 40 Hz, and the map of a plan of 50 x 50 m for publishing.

    Peer: the 25 ms there are between two scans.
    """
    say("map_update: whole mapper at 40 Hz")
    drive = corridor_loop(*BEAMS["1081"], seed, NUM_LIVE_SCANS)
    odometry = slipping_odometry(drive.truth, seed)
    mapper = GridMapper(GridMapperConfig(), T_map_start=drive.truth[0])
    times = []
    for k, (scan, odom) in enumerate(zip(drive.scans, odometry, strict=True)):
        started = time.perf_counter()
        mapper.insert_scan(k * LIVE_PERIOD_NS, scan, SE2.identity(), odom)
        times.append(1e3 * (time.perf_counter() - started))
    extra = {"map_mb": mapper.num_bytes / 1e6}
    median, p99 = median_and_p99(np.array(times))
    whole = Case("whole_1081_40hz", median, p99, "time between scans", 25.0, None, extra)
    grid = LabelGrid(LabelGridConfig(), RESOLUTION_M)
    for x in range(-20, 21, 10):
        for y in range(-20, 21, 10):
            grid.add_scan(drive.scans[0], SE2(float(x), float(y), 0.3))
    shape = grid.occupancy().cells.shape
    ms = take_turns({"occupancy": grid.occupancy}, 20)["occupancy"]
    extra = {"rows": shape[0], "cols": shape[1]}
    return [whole, Case("occupancy_50m", *median_and_p99(ms), extra=extra)]


def _race(scans: list[tuple[Scan, SE2]]) -> dict[str, np.ndarray]:
    """Enter the scans in a map of each kind, in turns; return ms of each call by name."""
    label = LabelGrid(LabelGridConfig(), RESOLUTION_M)
    log_odds = LogOddsGrid(LogOddsConfig(), RESOLUTION_M)
    plain, counts = _PlainTrace(), np.zeros((400, 400), np.int16)
    ms: dict[str, list[np.ndarray]] = {}
    for scan, pose in scans:
        plain.place(scan, pose)
        calls = {
            "label": partial(label.add_scan, scan, pose),
            "log_odds": partial(log_odds.add_scan, scan, pose),
            "plain": plain.trace,
            "floor": partial(np.add, counts, 1, out=counts),
        }
        for name, values in take_turns(calls, 3).items():
            ms.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in ms.items()}


class _PlainTrace:
    """The shortest ray trace there is, over a dense array round the origin."""

    def __init__(self) -> None:
        self._cells = np.zeros((DENSE_CELLS, DENSE_CELLS), np.float32)

    def place(self, scan, pose) -> None:  # type: ignore[no-untyped-def]
        """Prepare the beams of a scan; not part of what is timed."""
        beams = beams_of(scan, pose, NO_RETURN_M)
        ends = beams.origins + beams.ranges[:, None] * np.column_stack(
            (np.cos(beams.angles), np.sin(beams.angles))
        )
        half = DENSE_CELLS // 2
        self._start = (beams.origins[0] / RESOLUTION_M + half).astype(np.int64)
        self._ends = (ends / RESOLUTION_M + half).astype(np.int64)

    def trace(self) -> None:
        """Trace the beams."""
        _trace(self._cells, self._start, self._ends, np.float32(-0.4), np.float32(0.85))


@numba.njit(cache=True)
def _trace(cells, start, ends, miss, hit):  # type: ignore[no-untyped-def]
    limit = np.float32(3.5)
    for i in range(len(ends)):
        x, y = start
        end_x, end_y = ends[i]
        dx, dy = abs(end_x - x), -abs(end_y - y)
        step_x, step_y = (1 if end_x > x else -1), (1 if end_y > y else -1)
        error = dx + dy
        while x != end_x or y != end_y:
            cells[y, x] = max(cells[y, x] + miss, -limit)
            twice = 2 * error
            if twice >= dy:
                error += dy
                x += step_x
            if twice <= dx:
                error += dx
                y += step_y
        cells[end_y, end_x] = min(cells[end_y, end_x] + hit, limit)
