"""Laps round a simulated corridor, before and after closing loops; the values of `loop` are of it.

Drives: two laps of the 66 m ring, the second up to 0.4 m beside the first, 180 beams over 180
degrees, odometry whose wheels slip by up to 10 %: key scans (0.53 m and up to 25 degrees apart) and
11 cm apart. Rows: `all_scans` fits each scan to the map of all before it, `open` to what was seen
lately, `closed` is `open` corrected by the graph. *Revisit* is the mean error of the motion
between poses within 1 m of each other and more than a third of a lap apart. A loop counts as false
where it is off by more than 0.3 m or 5 degrees. Ground truth is used to make the scans and to
measure. *Looks* is the largest difference in looks of a place and one within 1 m of it, of a lap
before: `loop.max_difference_m` is twice that of the default drives, rounded. NEES says whether the
covariances of motions, loops and poses, by which loops are looked for and judged, are true.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from experiments import consistency
from experiments.corridor_loop import Drive, ring_laps, slipping_odometry
from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.wrong_loops import num_wrong
from floornav_common.arguments import count
from floornav_common.reporting import Progress, Section, Table
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.localizer import ScanLocalizer
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.place_appearance import Appearances
from grid_mapper.trajectory_metrics import trajectory_errors

FIRST_SEED = 200
STEP_NS = 400_000_000
SCANS_A_LAP = {"key_scans": 125, "dense": 600}
METHODS = ("all_scans", "open", "closed")
NEAR_M = 1.0
HERE = SE2.identity()


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--runs", type=count, default=4, metavar="N", help="seeds a drive (4)")
    add_spread_options(parser, jobs=1)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run all drives; fills `values["drives"]` and `values["false_loops_accepted"]`."""
    values["drives"], values["false_loops_accepted"] = {}, 0
    values["looks_m"], values["nees"] = 0.0, {}
    rows = []
    seeds = range(FIRST_SEED + args.seed, FIRST_SEED + args.seed + args.runs)
    tasks = [(num_scans, seed) for num_scans in SCANS_A_LAP.values() for seed in seeds]
    done = run_tasks(_measure, tasks, args.jobs, args.cluster)
    with Progress("loop-drives", len(SCANS_A_LAP) * args.runs, is_quiet=args.quiet) as progress:
        for name in SCANS_A_LAP:
            runs, samples = [], []
            for _ in range(args.runs):
                _, (found, errors) = next(done)
                runs.append(found)
                samples.append(errors)
                progress.update(len(values["drives"]) * args.runs + len(runs), name)
            values["drives"][name] = {
                method: {key: float(np.mean([r[method][key] for r in runs])) for key in found}
                for method, found in runs[0].items()
            }
            looks = [r["closed"]["looks_m"] for r in runs]
            values["looks_m"] = max(values["looks_m"], *looks)
            values["false_loops_accepted"] += round(sum(r["closed"]["false_loops"] for r in runs))
            values["nees"][name] = consistency.drive_figures(samples, GridMapperConfig().loop)
            rows += [_row(name, method, values["drives"][name][method]) for method in METHODS]
    header = ["drive", "poses", "ATE m", "revisit m", "revisit deg", "loops", "false loops"]
    looks_line = f"Looks: at most {values['looks_m']:.2f} m."
    nees = [consistency.__doc__ or "", consistency.table(values["nees"])]
    return [
        Section("Laps", [__doc__ or "", Table(header, rows), looks_line]),
        Section("Whether uncertainties are true", nees),
    ]


def _measure(task: tuple[int, int]) -> tuple[dict[str, dict[str, float]], consistency.Samples]:
    """Return the figures and the NEES of one drive: scans a lap, and seed."""
    num_scans, seed = task
    drive = ring_laps(180, np.pi, seed, num_scans)
    odometry = slipping_odometry(drive.truth, seed)
    config = GridMapperConfig()
    plain, closing = ScanLocalizer(config), LoopClosingLocalizer(config)
    poses: dict[str, list[SE2]] = {"all_scans": [], "open": []}
    covs: list[np.ndarray] = []
    for k, (scan, odom) in enumerate(zip(drive.scans, odometry, strict=True)):
        poses["all_scans"].append(plain.localize(k * STEP_NS, scan, HERE, odom).T_map_base)
        result = closing.insert_scan(k * STEP_NS, scan, HERE, odom)
        poses["open"].append(result.T_map_base)
        covs.append(result.cov)
    closing.closer.finish()
    poses["closed"] = [known.T_map_base for known in closing.known_poses()]
    figures = {method: _errors(drive.truth, poses[method]) for method in METHODS}
    figures["closed"] |= _loops(closing.closer, drive)
    nodes = [drive.truth[frame.stamp_ns // STEP_NS] for frame in closing.closer.frames]
    open_poses = (poses["open"], covs, drive.truth)
    return figures, consistency.drive_nees(closing.closer, nodes, *open_poses)


def _errors(truth: list[SE2], poses: list[SE2]) -> dict[str, float]:
    stamped = [list(enumerate(p)) for p in (poses, truth)]
    errors = [
        truth[i].between(truth[j]).between(poses[i].between(poses[j])) for i, j in _revisits(truth)
    ]
    return {
        "ate_m": trajectory_errors(*stamped, tolerance_ns=0).ate,
        "revisit_m": float(np.mean([e.distance for e in errors])),
        "revisit_deg": float(np.rad2deg(np.mean([abs(e.yaw) for e in errors]))),
    }


def _revisits(truth: list[SE2]) -> list[tuple[int, int]]:
    """Return pairs of poses at one place on different laps: of each pose the nearest."""
    points, lap = np.array([(p.x, p.y) for p in truth]), len(truth) // 2
    pairs = []
    for i in range(0, lap, 3):
        distance = np.hypot(*(points - points[i]).T)
        distance[abs(np.arange(len(points)) - i) < lap // 3] = np.inf
        if distance.min() < NEAR_M:
            pairs.append((i, int(np.argmin(distance))))
    return pairs


def _loops(closer: LoopCloser, drive: Drive) -> dict[str, float]:
    truth = [drive.truth[frame.stamp_ns // STEP_NS] for frame in closer.frames]
    loops = [edge for edge in closer.edges if edge.is_loop]
    looks = largest_difference(closer, truth)
    return {"loops": len(loops), "false_loops": num_wrong(loops, truth), "looks_m": looks}


def largest_difference(closer: LoopCloser, truth: list[SE2]) -> float:
    """Return by how much a place looks other than one near it on another lap, at most, m."""
    looks = Appearances(closer.config.loop.submap_nodes)
    points, largest = np.array([(p.x, p.y) for p in truth]), 0.0
    for number, frame in enumerate(closer.frames):
        looks.add(frame.points.points)
        num_before = max(0, number + 1 - len(truth) // 6)  # a third of a lap
        is_near = np.hypot(*(points[:num_before] - points[number]).T) < NEAR_M
        differences = looks.differences()[:num_before]
        largest = max(largest, float(differences[is_near].max(initial=0.0)))
    return largest


def _row(drive: str, method: str, f: dict[str, float]) -> list[str]:
    loops = [f"{f[key]:.0f}" if key in f else "-" for key in ("loops", "false_loops")]
    cells = [f"{f['ate_m']:.3f}", f"{f['revisit_m']:.4f}", f"{f['revisit_deg']:.3f}"]
    return [drive, method, *cells, *loops]
