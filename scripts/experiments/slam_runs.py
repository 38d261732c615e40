"""One floor of `slam`: the drive by every method, its poses and maps beside the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from experiments import consistency
from experiments.bench_scan_matching import kiss_icp_step
from experiments.corridor_loop import Drive
from experiments.glass_logs import GlassLog
from experiments.glass_methods import Mapped, Track, mapped, row_of, true_track
from experiments.glass_metrics import judge
from experiments.glass_pictures import write_rows
from experiments.glass_truth import Truth, truth_of
from experiments.slam_drives import drive_floor
from experiments.slam_false_loops import FalseLoops
from experiments.slam_measures import map_iou, seen_area
from experiments.wrong_loops import num_wrong
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.localizer import ScanLocalizer
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.trajectory_metrics import align, trajectory_errors

METHODS = (
    "odometry", "kiss_icp", "all_scans", "before", "after", "after_false_loops", "true_poses",
)  # fmt: skip
MAPPED = ("before", "after", "after_false_loops", "true_poses")
PICTURED = ("before", "after", "true_poses")
FIGURES = ("ate_m", "rpe_m", "map_iou", "glass_recall")
SPUN_M_S = 0.1
"""Where odometry runs ahead of the truth by more than this wheels spin."""


@dataclass(frozen=True)
class Job:
    """A floor to drive and map.

    Attributes:
        world: Name of the floor.
        seed: Of the drive and of the wrong loops.
        logs: Folder of drives that are kept.
        pictures: Folder for a picture; None draws none.
    """

    world: str
    seed: int
    logs: Path
    pictures: Path | None


@dataclass(frozen=True)
class Found:
    """Poses of a method, one a scan, whether each is to be trusted, and covariances if known."""

    poses: list[SE2]
    is_trusted: list[bool]
    covs: list[np.ndarray] = field(default_factory=list)


def run_floor(job: Job) -> dict[str, Any]:
    """Return all figures of one floor."""
    log = drive_floor(job.world, job.seed, job.logs)
    truth = [SE2(*row) for row in log.scan_true.tolist()]
    found = {"odometry": _odometry(log), "kiss_icp": _kiss_icp(log), "all_scans": _all_scans(log)}
    started = time.process_time()
    found["before"], found["after"], closer = _closed(log, None)
    cpu_s = time.process_time() - started
    wrong = FalseLoops(truth, log.scan_ns, np.random.default_rng((job.seed, 31)))
    _, found["after_false_loops"], spoiled = _closed(log, wrong)
    found["true_poses"] = Found(truth, [True] * len(truth))
    nodes, before = true_nodes(closer, truth, log), found["before"]
    samples = consistency.drive_nees(closer, nodes, before.poses, before.covs, truth)
    nees = consistency.drive_figures([samples], closer.config.loop)
    rows, maps = _judged(log, truth, found)
    result: dict[str, Any] = {
        "world": job.world, "seed": job.seed, "methods": rows, **_drive_figures(log),
        "closing_cpu_s": cpu_s, "nodes": len(closer.frames), "loops": closer.num_loops,
        "loops_refused": dict(sorted(closer.refused.items())),
        "false_loops_found": num_false(closer, truth, log),
        "false_loops_injected": wrong.num, "false_loops_kept": wrong.num_kept(spoiled),
        "false_loops_led_to": num_false(spoiled, truth, log, wrong),
        "loops_before_the_first_false": wrong.num_loops_before,
        "nees": nees, "pictures": [],
    }  # fmt: skip
    if job.pictures is not None:
        path = job.pictures / f"{job.world.replace(':', '-')}.png"
        write_rows(path, maps[0], {name: maps[1][name] for name in PICTURED})
        result["pictures"].append(str(path))
    return result


def true_nodes(closer: LoopCloser, truth: list[SE2], log: GlassLog) -> list[SE2]:
    """Return the true poses of a graph's nodes."""
    at = {int(ns): pose for ns, pose in zip(log.scan_ns, truth, strict=True)}
    return [at[frame.stamp_ns] for frame in closer.frames]


def num_false(
    closer: LoopCloser, truth: list[SE2], log: GlassLog, wrong: FalseLoops | None = None
) -> int:
    """Return how many loops that a graph found itself are wrong, those slipped in not counted."""
    loops = [e for e in closer.edges if e.is_loop and not (wrong and wrong.is_made(e))]
    return num_wrong(loops, true_nodes(closer, truth, log))


def _odometry(log: GlassLog) -> Found:
    poses = [SE2(*row) for row in log.scan_odom.tolist()]
    return Found(poses, [True] * len(poses))


def _kiss_icp(log: GlassLog) -> Found:
    scans = [log.scan(k).scan for k in range(len(log.scan_ns))]
    step = kiss_icp_step(Drive(scans, [SE2.identity()]))
    clouds = [np.pad(log.T_base_laser @ scan.points(), ((0, 0), (0, 1))) for scan in scans]
    poses = [step(k, cloud) for k, cloud in enumerate(clouds)]
    return Found(poses, [True] * len(poses))


def _all_scans(log: GlassLog) -> Found:
    """Return the poses of `loop_closing: false`."""
    localizer = ScanLocalizer(GridMapperConfig())
    events = [log.scan(k) for k in range(len(log.scan_ns))]
    results = [localizer.localize(e.stamp_ns, e.scan, e.T_base_laser, e.T_odom_base)
               for e in events]  # fmt: skip
    return Found([r.T_map_base for r in results], [r.is_trusted for r in results])


def _closed(log: GlassLog, wrong: FalseLoops | None) -> tuple[Found, Found, LoopCloser]:
    """Return poses before and after closing loops; wrong ones are slipped in on the way."""
    localizer = LoopClosingLocalizer(GridMapperConfig())
    poses, trusted, covs = [], [], []
    for k in range(len(log.scan_ns)):
        event = log.scan(k)
        result = localizer.insert_scan(
            event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base
        )
        poses.append(result.T_map_base)
        trusted.append(result.is_trusted)
        covs.append(result.cov)
        if wrong is not None:
            wrong.slip_in(localizer.closer, (k + 1) / len(log.scan_ns))
    localizer.closer.finish()
    known = localizer.known_poses()
    after = Found([pose.T_map_base for pose in known], [pose.is_trusted for pose in known])
    return Found(poses, trusted, covs), after, localizer.closer


def _judged(
    log: GlassLog, truth: list[SE2], found: dict[str, Found]
) -> tuple[dict[str, dict[str, float | None]], tuple[Truth, dict[str, Mapped]]]:
    """Return the figures of every method, and the maps; all are laid on the truth as ATE does."""
    world, config = truth_of(log), GridMapperConfig()
    maps = {}
    for name in MAPPED:
        track = true_track(log) if name == "true_poses" else _track(log, truth, found[name])
        maps[name] = row_of(mapped(log, config, track))
    area = seen_area(maps["true_poses"].occupancy, world)
    rows: dict[str, dict[str, float | None]] = {}
    for name in METHODS:
        errors = trajectory_errors(*(_stamped(log, p) for p in (found[name].poses, truth)), 0)
        rows[name] = {"ate_m": errors.ate, "rpe_m": errors.rpe, **dict.fromkeys(FIGURES[2:])}
        if name in maps:
            judged = judge(maps[name].occupancy, maps[name].glass, world)
            rows[name]["map_iou"] = map_iou(maps[name].occupancy, world, area)
            rows[name]["glass_recall"] = judged["glass_recall"]
    return rows, (world, maps)


def _track(log: GlassLog, truth: list[SE2], found: Found) -> Track:
    points, targets = (np.array([(p.x, p.y) for p in poses]) for poses in (found.poses, truth))
    T_truth_map, track = align(points, targets), Track()
    for ns, pose, is_trusted in zip(
        log.scan_ns.tolist(), found.poses, found.is_trusted, strict=True
    ):
        if is_trusted:
            track.poses.add(ns, T_truth_map @ pose)
    return track


def _stamped(log: GlassLog, poses: list[SE2]) -> list[tuple[int, SE2]]:
    return list(zip(log.scan_ns.tolist(), poses, strict=True))


def _drive_figures(log: GlassLog) -> dict[str, Any]:
    return {
        "way_m": float(np.hypot(*np.diff(log.scan_true[:, :2], axis=0).T).sum()),
        "scans": len(log.scan_ns),
        "is_route_complete": bool(log.is_complete),
        "touches": int(log.num_touches),
        "spun_s": spun_s(log.scan_ns, log.scan_odom, log.scan_true),
    }


def spun_s(stamps_ns: np.ndarray, odometry: np.ndarray, truth: np.ndarray) -> float:
    """Return for how many seconds wheels spun: odometry ran ahead of the truth by over SPUN_M_S.

    Args:
        stamps_ns: Stamps, (n,).
        odometry: Poses by odometry, (n, 3), m and rad.
        truth: True poses, (n, 3).
    """
    steps_s = np.diff(stamps_ns) * 1e-9
    told, true = (np.hypot(*np.diff(poses[:, :2], axis=0).T) for poses in (odometry, truth))
    return float(steps_s[(told - true) > SPUN_M_S * steps_s].sum())
