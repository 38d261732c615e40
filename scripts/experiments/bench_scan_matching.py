"""Time and drift of scan-to-map ICP on the corridor loop, beside kiss-icp and genz-icp.

All get the same points of the same scans in the same run, scan by scan in turns, and nothing else:
no odometry, constant velocity as the start. Ours is timed from ranges to pose, its map update
included. kiss-icp and genz-icp run with their own settings, 0.2 m voxels and no motion
compensation. Floor: the points from the ranges and one look-up of each in a grid.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from experiments.corridor_loop import Drive, corridor_loop
from experiments.timing import Case, median_and_p99
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.localizer import ScanLocalizer
from grid_mapper.warm_up import compile_kernels

SCAN_PERIOD_NS = 100_000_000
BEAMS = {"180": (180, np.pi), "360": (360, 2.0 * np.pi), "1081": (1081, 1.5 * np.pi)}
NUM_SEEDS, FIRST_SEED = 8, 200  # no value of ours was chosen on these
VOXEL_M = 0.2
Step = Callable[[int, np.ndarray], SE2]


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each number of beams, over `NUM_SEEDS` loops."""
    compile_kernels()
    cases = []
    for name, (num_beams, fov) in BEAMS.items():
        ms: dict[str, list[float]] = {}
        ends: dict[str, list[float]] = {}
        for k in range(NUM_SEEDS):
            say(f"scan_matching: {name} beams, loop {k + 1} of {NUM_SEEDS}")
            drive = corridor_loop(num_beams, fov, FIRST_SEED + seed + k)
            for who, (times, poses) in _race(drive).items():
                ms.setdefault(who, []).extend(times)
                ends.setdefault(who, []).append(drive.truth[-1].between(poses[-1]).distance)
        cases.append(_case(name, ms, ends))
    return cases


def _case(name: str, ms: dict[str, list[float]], ends: dict[str, list[float]]) -> Case:
    ours, p99 = median_and_p99(np.array(ms["floornav"]))
    extra = {
        "genz_icp_median_ms": float(np.median(ms["genz-icp"])),
        "loop_m": 66.0,
        "seeds": NUM_SEEDS,
    }
    for who, key in (("floornav", ""), ("kiss-icp", "kiss_icp_"), ("genz-icp", "genz_icp_")):
        extra[f"{key}end_error_m"] = float(np.median(ends[who]))
        extra[f"{key}end_error_max_m"] = float(np.max(ends[who]))
    peer = float(np.median(ms["kiss-icp"]))
    return Case(name, ours, p99, "kiss-icp", peer, float(np.median(ms["floor"])), extra)


def _race(drive: Drive) -> dict[str, tuple[list[float], list[SE2]]]:
    """Feed every scan to each matcher in turn."""
    matchers = {
        "floornav": _floornav(drive),
        "kiss-icp": kiss_icp_step(drive),
        "genz-icp": _genz_icp(drive),
        "floor": _floor(drive),
    }
    results: dict[str, tuple[list[float], list[SE2]]] = {n: ([], []) for n in matchers}
    for k, scan in enumerate(drive.scans):
        points = np.column_stack((scan.points(), np.zeros(int(scan.is_hit.sum()))))
        for name, step in matchers.items():
            started = time.perf_counter()
            pose = step(k, points)
            results[name][0].append(1e3 * (time.perf_counter() - started))
            results[name][1].append(pose)
    return results


def _floornav(drive: Drive) -> Step:
    localizer = ScanLocalizer(GridMapperConfig(), T_map_start=drive.truth[0])

    def step(k: int, _points: np.ndarray) -> SE2:
        stamp_ns = k * SCAN_PERIOD_NS
        return localizer.localize(stamp_ns, drive.scans[k], SE2.identity(), None).T_map_base

    return step


def kiss_icp_step(drive: Drive) -> Step:
    """Return kiss-icp as a step: scan number and points (N, 3) to pose."""
    from kiss_icp.config import KISSConfig
    from kiss_icp.kiss_icp import KissICP

    config = KISSConfig()
    config.data.deskew, config.data.max_range, config.mapping.voxel_size = False, 30.0, VOXEL_M
    config.registration.max_num_threads = 1
    return _lidar_odometry(KissICP(config), drive)


def _genz_icp(drive: Drive) -> Step:
    from genz_icp.config import GenZConfig
    from genz_icp.genz_icp import GenZICP

    config = GenZConfig()
    config.data.deskew, config.data.max_range, config.mapping.voxel_size = False, 30.0, VOXEL_M
    config.data.min_range = 0.0
    config.registration.max_num_threads = 1
    return _lidar_odometry(GenZICP(config), drive)


def _lidar_odometry(odometry, drive: Drive) -> Step:  # type: ignore[no-untyped-def]
    """Step a KissICP-like object; its first pose is the identity."""

    def step(_k: int, points: np.ndarray) -> SE2:
        odometry.register_frame(points, np.empty(0))
        T = odometry.last_pose
        return drive.truth[0] @ SE2(T[0, 3], T[1, 3], float(np.arctan2(T[1, 0], T[0, 0])))

    return step


def _floor(drive: Drive) -> Step:
    """Return what cannot be saved: points from ranges, and one look-up of each in a grid."""
    distances = np.zeros((600, 600), np.float32)

    def step(k: int, _points: np.ndarray) -> SE2:
        points = drive.truth[k] @ drive.scans[k].points()
        cells = (points / 0.1 + 300.0).astype(np.int64)
        distances[cells[:, 1], cells[:, 0]].sum()
        return drive.truth[k]

    return step
