"""Time to make all layers (map, laser, sonar, glass) for publishing, on a plan of 50 x 50 m.

The plan is made of one simulated drive along a glass wall, laid out five times: at the four corners
and in the middle. Before each call a scan and a reading come in, so that nothing can be kept from
the call before. Peer: the laser's map by itself; floor: one pass over the plan's cells.

Then the drive is localized and mapped once more while another thread makes layers of that plan all
the time, as the node's does at each publish: what a scan with its match, and all readings since,
takes then. Peer: the same with nothing made meanwhile.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from experiments.bench_sonar_update import FUSIONS, LIMIT_P99_MS, WORLD, clocks
from experiments.glass_logs import GlassLog, drive
from experiments.timing import Case, median_and_p99
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.layers_moment import Layers
from grid_mapper.recordings.events import ScanEvent

PLAN_M = 50.0
NUM_CALLS = 40
_WARM_UP = 20


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each method."""
    say(f"glass_map: simulated drive through {WORLD}")
    log = drive(WORLD, seed)
    cases = []
    for fusion in FUSIONS:
        say(f"glass_map: {fusion}")
        mapper = LayeredMapper(GridMapperConfig(fusion=fusion), log.start)
        for number, place in enumerate(_places(log)):
            _lay_out(mapper, log, place, number)
        ms = _publish(mapper, log)
        cells = mapper.layers().occupancy.cells
        extra = {"rows": cells.shape[0], "cols": cells.shape[1], "mb": mapper.num_bytes / 1e6}
        peer, floor = (float(np.median(ms[name])) for name in ("laser's map", "floor"))
        median, p99 = median_and_p99(ms["layers"])
        cases.append(Case(f"publish_{fusion}", median, p99, "laser's map", peer, floor, extra))
        cases.append(_update_case(f"update_meanwhile_{fusion}", mapper, log))
    return cases


def _update_case(name: str, mapper: LayeredMapper, log: GlassLog) -> Case:
    """Return the time of a whole update while layers are made all the time, and without."""
    alone, _ = _updates(mapper, log, 2 * 10**14, makes_layers=False)
    ms, num = _updates(mapper, log, 3 * 10**14, makes_layers=True)
    median, p99 = median_and_p99(ms[:, 0])
    peer, peer_p99 = median_and_p99(alone[:, 0])
    extra = {
        "computed_p99_ms": median_and_p99(ms[:, 1])[1], "alone_p99_ms": peer_p99,
        "layers_made": num, "longest_ms": float(ms[:, 0].max()),
        "limit_p99_ms": LIMIT_P99_MS, "reached": "yes" if p99 < LIMIT_P99_MS else "no",
    }  # fmt: skip
    return Case(name, median, p99, "no layers made", peer, None, extra)


def _updates(
    mapper: LayeredMapper, log: GlassLog, offset_ns: int, *, makes_layers: bool
) -> tuple[np.ndarray, int]:
    """Return ms of each scan with its match and the readings since, and how often layers were.

    Columns: by the clock, and of them those that this thread computed, shape (N, 2).
    """
    mapper.break_motion()
    mapper.relocate(log.start)
    times, spent, num, making = [], np.zeros(2), 0, None
    with ThreadPoolExecutor(1) as pool:
        for event, _ in log.events():
            started, stamp_ns = clocks(), event.stamp_ns + offset_ns
            if not isinstance(event, ScanEvent):
                mapper.insert_range(stamp_ns, event.reading, event.T_base_sonar, event.frame)
                spent += clocks() - started
                continue
            mapper.insert_scan(stamp_ns, event.scan, event.T_base_laser, event.T_odom_base)
            if makes_layers and (making is None or making.done()):
                making, num = _begin(pool, mapper, making), num + 1
            times.append(1e3 * (spent + clocks() - started))
            spent = np.zeros(2)
    return np.array(times[_WARM_UP:]), num


def _begin(
    pool: ThreadPoolExecutor, mapper: LayeredMapper, before: Future[Layers] | None
) -> Future[Layers]:
    """Have the layers made of what is known now; raises what went wrong with those before."""
    if before is not None:
        before.result()
    return pool.submit(mapper.moment().layers)


def _places(log: GlassLog) -> list[SE2]:
    """Return where the drive is laid out: so that all together spans the plan."""
    low, high = _extent(log)
    room = PLAN_M - (high - low)
    shares = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5))
    return [SE2(float(room[0] * x), float(room[1] * y), 0.0) for x, y in shares]


def _extent(log: GlassLog) -> tuple[np.ndarray, np.ndarray]:
    corners = np.vstack([solid.outline() for solid in log.solids()])
    return corners.min(axis=0), corners.max(axis=0)


def _lay_out(mapper: LayeredMapper, log: GlassLog, place: SE2, number: int) -> None:
    offset_ns = number * 10**12
    for event, pose in log.events():
        stamp_ns, moved = event.stamp_ns + offset_ns, place @ pose
        if isinstance(event, ScanEvent):
            mapper.place_scan(stamp_ns, event.scan, event.T_base_laser, moved)
        else:
            mapper.place_range(stamp_ns, event.reading, event.T_base_sonar, event.frame, moved)


def _publish(mapper: LayeredMapper, log: GlassLog) -> dict[str, np.ndarray]:
    """Return ms of making the layers, the laser's map alone and of one pass over the cells."""
    counts = np.zeros(mapper.laser.occupancy().cells.shape, np.int16)
    ms: dict[str, list[float]] = {"layers": [], "laser's map": [], "floor": []}
    stamp_ns = 10**14
    for k in range(NUM_CALLS):
        stamp_ns += 10**10  # so long after that it is a key scan
        scan, echo = log.scan(k), log.range(k)
        pose = SE2(*log.scan_true[k].tolist())
        mapper.place_scan(stamp_ns, scan.scan, scan.T_base_laser, pose)
        mapper.place_range(stamp_ns, echo.reading, echo.T_base_sonar, echo.frame, pose)
        calls: dict[str, Callable[[], object]] = {
            "layers": mapper.layers,
            "laser's map": mapper.laser.occupancy,
            "floor": lambda: np.add(counts, 1, out=counts),
        }
        for name, call in calls.items():
            started = time.perf_counter()
            call()
            ms[name].append(1e3 * (time.perf_counter() - started))
    return {name: np.array(values[1:]) for name, values in ms.items()}
