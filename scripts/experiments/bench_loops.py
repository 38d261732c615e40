"""How long a scan is held up by what closes loops behind its back: a live session over some laps.

Ten times a second a scan (541 beams) and 8 sonar readings go to the mapper, while a process of its
own closes loops and makes maps anew. A scan can wait for news of it: taking answers in, bringing
new maps up to now, letting them take the place of the old; and no thread of the node goes on while
another reads a large answer or the collector looks for garbage. Of the first the time is taken, of
the others the processor time of their threads, so that other work on the machine counts little.
The hold-up is the greatest of each, added: for a scan that comes in the worst moment of all.
"""

from __future__ import annotations

import gc
import importlib
import time
from collections.abc import Callable

import numpy as np

from experiments.corridor_loop import Drive, ring_laps
from experiments.timing import Case, median_and_p99
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.background import ProcessWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig
from grid_mapper.loop_session import LoopSession
from grid_mapper.warm_up import compile_kernels

BEAMS, FOV_RAD = 541, 4.71
SCANS_A_LAP, LAPS, PERIOD_S = 250, 3, 0.1
NUM_SONARS = 8
STANDS_EVERY, STANDS_S = 60, 60.0
"""Scans after which the robot stands, once it was everywhere, until maps are made anew; at most."""
LIMIT_MS = 50.0
SLIP = SE2(0.0, 0.0, 0.002)
"""Odometry turns too far by this a scan."""


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return the case."""
    say("loops: simulated drive")
    importlib.import_module("grid_mapper.nodes.grid_mapper_node")  # what a collector goes through
    config = GridMapperConfig()
    drive = ring_laps(BEAMS, FOV_RAD, seed, SCANS_A_LAP, LAPS)
    compile_kernels(config.fusion, has_loops=True)
    imported_ms = _collection_ms()
    gc.freeze()  # as the node does
    say(f"loops: a live session, {len(drive.scans) * PERIOD_S:.0f} s and what it waits for maps")
    try:
        return [_session(drive, config, imported_ms)]
    finally:
        gc.unfreeze()


def _collection_ms() -> float:
    """Return the processor time of a full collection, ms."""
    started = time.thread_time()
    gc.collect()
    return 1e3 * (time.thread_time() - started)


class _Collections:
    """The longest collection, in processor time of the thread that it came up in."""

    def __init__(self) -> None:
        self.longest_ms, self._started = 0.0, 0.0

    def __call__(self, phase: str, _: dict[str, int]) -> None:
        """Take the beginning or the end of one."""
        if phase == "start":
            self._started = time.thread_time()
        else:
            took_ms = 1e3 * (time.thread_time() - self._started)
            self.longest_ms = max(self.longest_ms, took_ms)


def _session(drive: Drive, config: GridMapperConfig, imported_ms: float) -> Case:
    mapper = ClosingMapper(config, ProcessWorker(LoopSession, config))
    collections = _Collections()
    gc.callbacks.append(collections)
    try:
        took = _drive(mapper, drive)
        _collection_ms()  # a full one at least, with all that the session holds
    finally:
        gc.callbacks.remove(collections)
        mapper.close()
    held_ms = mapper.longest_hold_up_ms + collections.longest_ms
    median, p99 = median_and_p99(1e3 * np.array(took))
    extra = {
        "hold_up_ms": held_ms, "news_ms": mapper.longest_wait_ms,
        "answer_read_ms": mapper.link.longest_read_ms, "collection_ms": collections.longest_ms,
        "limit_ms": LIMIT_MS, "reached": "yes" if held_ms < LIMIT_MS else "no",
        "maps_made_anew": mapper.num_swaps, "loops": mapper.graph.num_loops,
        "full_collection_without_freezing_ms": imported_ms, "failure": mapper.failure or "none",
    }  # fmt: skip
    return Case("live_session", median, p99, None, None, None, extra)


def _drive(mapper: ClosingMapper, drive: Drive) -> list[float]:
    """Drive at the pace of a robot, and stand now and then; return how long each scan took, s."""
    took, odometry, before = [], SE2.identity(), drive.truth[0]
    stamp_ns = 0
    for k, (scan, pose) in enumerate(zip(drive.scans, drive.truth, strict=True)):
        odometry, before = odometry @ before.between(pose) @ SLIP, pose
        num_swaps = mapper.num_swaps
        stands = k > SCANS_A_LAP and k % STANDS_EVERY == STANDS_EVERY - 1
        until = time.monotonic() + STANDS_S * stands
        while True:
            begun = time.monotonic()
            stamp_ns += round(1e9 * PERIOD_S)
            took.append(_insert(mapper, stamp_ns, scan, odometry))
            time.sleep(max(0.0, begun + PERIOD_S - time.monotonic()))
            if mapper.num_swaps > num_swaps or time.monotonic() >= until:
                break
    return took


def _insert(mapper: ClosingMapper, stamp_ns: int, scan: Scan, odometry: SE2) -> float:
    """Hand over a scan and the readings round it; return how long the scan took, s."""
    started = time.perf_counter()
    mapper.insert_scan(stamp_ns, scan, SE2.identity(), odometry)
    took = time.perf_counter() - started
    for sonar in range(NUM_SONARS):
        place = SE2(0.0, 0.0, sonar * 2.0 * np.pi / NUM_SONARS)
        steps = round(stamp_ns * 1e-9 / PERIOD_S) + sonar
        reading = RangeReading(0.5 + 0.1 * (steps % 20), 0.3, 0.02, 4.0)
        mapper.insert_range(stamp_ns - 1, reading, place, f"sonar_{sonar}")
    return took
