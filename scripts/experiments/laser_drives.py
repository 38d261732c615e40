"""Drift of laser mapping on simulated drives, beside kiss-icp and odometry alone.

Drives: the corridor loop at 40 Hz (3.3 cm a scan), its key scans (0.53 m and up to 25 degrees
apart), both with odometry whose wheels slip by up to 10 %, and 20 m of bare corridor, where a laser
cannot see the way along it. Range noise 1 cm. Seeds are not those of the benchmark. `kiss_icp` and
`floornav_no_odometry` get scans only, `floornav` odometry too. Ground truth is used to make the
scans and to measure, and for the first pose.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np

from experiments.bench_scan_matching import kiss_icp_step
from experiments.corridor_loop import Drive, bare_corridor, corridor_loop, slipping_odometry
from experiments.parallel_tasks import add_spread_options, run_tasks
from floornav_common.arguments import count
from floornav_common.reporting import Progress, Section, Table
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.localizer import ScanLocalizer

FIRST_SEED = 100
SPEED = 1.3  # m/s
DRIVES: dict[str, Callable[[int], Drive]] = {
    "loop_40hz_1081": lambda seed: corridor_loop(1081, 1.5 * np.pi, seed, 2000),
    "loop_key_scans_360": lambda seed: corridor_loop(360, 2.0 * np.pi, seed, 125),
    "loop_key_scans_180": lambda seed: corridor_loop(180, np.pi, seed, 125),
    "bare_corridor_360": lambda seed: bare_corridor(360, 2.0 * np.pi, seed),
}
METHODS = ("odometry", "kiss_icp", "floornav_no_odometry", "floornav")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--runs", type=count, default=10, metavar="N", help="seeds a drive (10)")
    add_spread_options(parser, jobs=1)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run all drives; fills `values["drives"]`."""
    values["drives"] = {}
    rows = []
    with Progress("laser-drives", len(DRIVES) * args.runs, is_quiet=args.quiet) as progress:
        tasks = [(name, args.seed + k) for name in DRIVES for k in range(args.runs)]
        results: dict[str, list[dict[str, float]]] = {m: [] for m in METHODS}
        done = run_tasks(_followed, tasks, args.jobs, args.cluster)
        for number, ((name, _), found) in enumerate(done, 1):
            for method in METHODS:
                results[method].append(found[method])
            progress.update(number, name)
            if number % args.runs == 0:  # the last seed of this drive
                values["drives"][name] = {m: _spread(r) for m, r in results.items()}
                rows += [_row(name, m, values["drives"][name][m]) for m in METHODS]
                results = {m: [] for m in METHODS}
    header = ["drive", "method", "end m (median)", "end m (worst)", "ATE m", "end deg", "refused"]
    return [Section("Drift", [__doc__ or "", Table(header, rows)])]


def _followed(task: tuple[str, int]) -> dict[str, dict[str, float]]:
    """Return the figures of every method on one drive of one seed."""
    name, seed = task
    drive = DRIVES[name](FIRST_SEED + seed)
    return {method: _measure(drive, _follow(method, drive, seed)) for method in METHODS}


def _follow(method: str, drive: Drive, seed: int) -> tuple[list[SE2], int]:
    """Return the poses a method finds, and how many scans it did not trust."""
    odometry = slipping_odometry(drive.truth, seed)
    if method == "odometry":
        return odometry, 0
    if method == "kiss_icp":
        step = kiss_icp_step(drive)
        clouds = [np.pad(scan.points(), ((0, 0), (0, 1))) for scan in drive.scans]
        return [step(k, cloud) for k, cloud in enumerate(clouds)], 0
    localizer = ScanLocalizer(GridMapperConfig(), T_map_start=drive.truth[0])
    period_ns = round(1e9 * drive.truth[0].between(drive.truth[1]).distance / SPEED)
    results = [
        localizer.localize(
            k * period_ns, scan, SE2.identity(), odometry[k] if method == "floornav" else None
        )
        for k, scan in enumerate(drive.scans)
    ]
    return [r.T_map_base for r in results], sum(not r.is_trusted for r in results)


def _measure(drive: Drive, found: tuple[list[SE2], int]) -> dict[str, float]:
    poses, refused = found
    off = [a.between(b) for a, b in zip(drive.truth, poses, strict=True)]
    return {
        "end_m": off[-1].distance,
        "end_deg": abs(float(np.rad2deg(off[-1].yaw))),
        "ate_m": float(np.sqrt(np.mean([o.distance**2 for o in off]))),
        "refused": refused,
    }


def _spread(runs: list[dict[str, float]]) -> dict[str, float]:
    """Return the median of every figure and the worst end."""
    medians = {key: float(np.median([r[key] for r in runs])) for key in runs[0]}
    return {**medians, "end_m_worst": max(r["end_m"] for r in runs), "runs": len(runs)}


def _row(drive: str, method: str, f: dict[str, float]) -> list[str]:
    cells = [f"{f[key]:.3f}" for key in ("end_m", "end_m_worst", "ate_m")]
    return [drive, method, *cells, f"{f['end_deg']:.2f}", f"{f['refused']:.0f}"]
