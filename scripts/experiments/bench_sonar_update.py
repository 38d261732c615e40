"""Time of a sonar reading, and of a whole update: a scan with its match and all readings since.

Input is a simulated drive along a glass wall (laser 10 Hz with 541 beams, 16 sonars at 5 Hz each).
A reading is placed and entered in the map, its pose given. Peer: the usual costmap layer for
sonars, re-made, on the same readings; floor: `classify`, which tells what a reading means. Of the
whole update the peer is the paper's ICP alone, on a Pentium 4 at 2.8 GHz: 1.045 s on average,
1.906 s at most.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from experiments.glass_logs import GlassLog, drive
from experiments.range_layer import RangeLayer
from experiments.timing import Case, median_and_p99
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.recordings.events import ScanEvent
from grid_mapper.sonar_reading import classify

WORLD = "glass_wall"
FUSIONS = ("overlay", "bayes")
PAPER_ICP_MS, PAPER_ICP_WORST_MS = 1045.0, 1906.0
LIMIT_P99_MS = 10.0
_WARM_UP = 200


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return the cases."""
    say(f"sonar_update: simulated drive through {WORLD}")
    log = drive(WORLD, seed)
    cases = []
    for fusion in FUSIONS:
        say(f"sonar_update: {fusion}")
        by_whom = _race(log, fusion)
        median, p99 = median_and_p99(by_whom["ours"])
        peer, floor = (float(np.median(by_whom[name])) for name in ("costmap layer", "floor"))
        extra = {"median_us": 1e3 * median, "p99_us": 1e3 * p99}
        cases.append(Case(f"reading_{fusion}", median, p99, "costmap layer", peer, floor, extra))
    for fusion in FUSIONS:
        say(f"sonar_update: whole update, {fusion}")
        ms = _whole(log, fusion)
        median, p99 = median_and_p99(ms[:, 0])
        extra = {
            "computed_p99_ms": median_and_p99(ms[:, 1])[1],
            "paper_icp_worst_ms": PAPER_ICP_WORST_MS, "limit_p99_ms": LIMIT_P99_MS,
            "reached": "yes" if p99 < LIMIT_P99_MS else "no",
        }  # fmt: skip
        name = f"whole_{fusion}"
        cases.append(Case(name, median, p99, "paper's ICP", PAPER_ICP_MS, None, extra))
    return cases


def _race(log: GlassLog, fusion: str) -> dict[str, np.ndarray]:
    """Return ms of each reading, at its true pose, by who took it; scans go in untimed."""
    mapper = LayeredMapper(GridMapperConfig(fusion=fusion), log.start)
    layer = RangeLayer(OccupancyMap(np.zeros((400, 400), np.int8), 0.05, SE2(-4.0, -7.0, 0.0)))
    ms: dict[str, list[float]] = {"ours": [], "costmap layer": [], "floor": []}
    for event, pose in log.events():
        if isinstance(event, ScanEvent):
            mapper.place_scan(event.stamp_ns, event.scan, event.T_base_laser, pose)
            continue
        reading, started = event.reading, time.perf_counter()
        mapper.place_range(event.stamp_ns, reading, event.T_base_sonar, event.frame, pose)
        ended = time.perf_counter()
        layer.add_range(reading, pose @ event.T_base_sonar)
        layer_ended = time.perf_counter()
        classify(reading)
        last = time.perf_counter()
        for name, span in zip(
            ms, (ended - started, layer_ended - ended, last - layer_ended), strict=True
        ):
            ms[name].append(1e3 * span)
    return {name: np.array(values[_WARM_UP:]) for name, values in ms.items()}


def _whole(log: GlassLog, fusion: str) -> np.ndarray:
    """Return ms of each scan with its match and all readings since the scan before, shape (N, 2).

    Columns: by the clock, and of them those computed: on a busy machine the rest is waiting.
    """
    mapper = LayeredMapper(GridMapperConfig(fusion=fusion), log.start)
    times, spent = [], np.zeros(2)
    for event, _ in log.events():
        started = clocks()
        if isinstance(event, ScanEvent):
            mapper.insert_scan(event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base)
        else:
            mapper.insert_range(event.stamp_ns, event.reading, event.T_base_sonar, event.frame)
        spent += clocks() - started
        if isinstance(event, ScanEvent):
            times.append(1e3 * spent)
            spent = np.zeros(2)
    return np.array(times[_WARM_UP // 10 :])


def clocks() -> np.ndarray:
    """Return the clock and the time that this thread has computed, s."""
    return np.array((time.perf_counter(), time.thread_time()))
