"""One glass world of `glass-map` from drive to figures, so that several can run side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.glass_logs import GlassLog, drive
from experiments.glass_measures import measured
from experiments.glass_methods import (
    Mapped,
    all_rows,
    compared_rows,
    localized,
    overlays_of,
    true_track,
)
from experiments.glass_metrics import judge
from experiments.glass_paths import count_crossings, pairs_behind_glass, pairs_of
from experiments.glass_pictures import write_figures, write_rows
from experiments.glass_truth import Truth, truth_of
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge.world import load_world

# Tables 1 and 2: what the paper's maps say, m and deg.
PAPER = {
    "glass_corridor": {"a": 2.50, "b": 90.0, "c": 0.65, "d": 0.50},
    "glass_wall": {"a": 2.55, "b": 90.0, "c": 3.60},
}
EXPERIMENT = {"glass_corridor": 1, "glass_wall": 2}
Rows = dict[str, Mapped | None]


@dataclass(frozen=True)
class Job:
    """What to do in one world.

    With `turn_rad` only lengths and angles are measured, in maps whose cells are turned so far
    against the walls.

    Attributes:
        world: Name or path.
        seed: Of the drive.
        logs: Folder of logs that are kept.
        num_pairs: Start-goal pairs to plan for.
        pairs_seed: Of these.
        pictures: Folder for pictures; None draws none.
        turn_rad: See above; None for all figures, cells along the walls.
    """

    world: str
    seed: int
    logs: Path
    num_pairs: int
    pairs_seed: int
    pictures: Path | None
    turn_rad: float | None = None


def run_job(job: Job) -> dict[str, Any]:
    """Return all figures of one world, or its lengths alone."""
    if job.turn_rad is not None:
        return run_lengths(job, job.turn_rad)
    log = drive(job.world, job.seed, cache=job.logs)
    truth, is_paper = truth_of(log), job.world in PAPER
    overlays, icp = overlays_of(is_paper_world=is_paper), localized(log)
    rows = all_rows(log, overlays, icp)
    truly = all_rows(log, overlays, true_track(log))
    result: dict[str, Any] = {
        **_drive_values(log, icp.errors_m, icp.num_untrusted),
        "icp": _each(rows, lambda row: judge(row.occupancy, row.glass, truth)),
        "true_poses": _each(truly, lambda row: judge(row.occupancy, row.glass, truth)),
        "pictures": [],
    }
    for name, choose in (("paths", pairs_of), ("paths_behind_glass", pairs_behind_glass)):
        pairs = choose(truth, job.num_pairs, np.random.default_rng(job.pairs_seed))
        result[name] = _each(rows, _crossings(truth, pairs))
    result["tables"] = _tables(job.world, log, rows) if is_paper else []
    if job.pictures is not None:
        name = job.world.replace(":", "-")
        path = job.pictures / f"{name}.png"
        write_rows(path, truth, rows)
        result["pictures"].append(str(path))
        if is_paper:
            path = job.pictures / f"{name}-figures.png"
            write_figures(path, log, truth, icp, overlays["overlay"])
            result["pictures"].append(str(path))
    return result


def run_lengths(job: Job, turn_rad: float) -> dict[str, Any]:
    """Return the lengths and angles of a paper's world, mapped on turned cells."""
    log = drive(job.world, job.seed, cache=job.logs)
    turn = SE2(0.0, 0.0, turn_rad)
    track = localized(log, turn @ log.start)
    rules = {"overlay": overlays_of(is_paper_world=True)["overlay"]}
    rows = {name: turned_back(row, turn) for name, row in compared_rows(log, rules, track).items()}
    tables = _tables(job.world, log, rows)
    extra = {"seed": job.seed, "turn_rad": turn_rad}
    return {"world": job.world, "lengths": [{**entry, **extra} for entry in tables]}


def turned_back(row: Mapped, turn: SE2) -> Mapped:
    """Return a row in the world's frame."""
    maps = [row.occupancy, row.glass]
    back = [m and OccupancyMap(m.cells, m.resolution, turn.inverse() @ m.origin) for m in maps]
    assert back[0] is not None
    return Mapped(back[0], back[1])


def _crossings(truth: Truth, pairs: np.ndarray) -> Callable[[Mapped], dict[str, Any]]:
    return lambda row: vars(count_crossings(row.occupancy, truth, pairs))


def _drive_values(log: GlassLog, errors_m: list[float], num_untrusted: int) -> dict[str, Any]:
    steps = np.diff(log.scan_true[:, :2], axis=0)
    off = log.scan_odom[-1, :2] - log.scan_odom[0, :2]
    moved = log.scan_true[-1, :2] - log.scan_true[0, :2]
    return {
        "world": log.world,
        "seed": log.seed,
        "way_m": float(np.hypot(*steps.T).sum()),
        "scans": len(log.scan_ns),
        "readings": len(log.range_ns),
        "is_route_complete": bool(log.is_complete),
        "touches": int(log.num_touches),
        "odometry_end_error_m": float(
            np.hypot(*(off - _turned(moved, -float(log.scan_true[0, 2]))))
        ),
        "pose_error_rms_m": float(np.sqrt(np.mean(np.square(errors_m)))),
        "pose_error_max_m": float(np.max(errors_m)),
        "scans_not_trusted": num_untrusted,
    }


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array((c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]))


def _each(
    rows: Rows, figures: Callable[[Mapped], dict[str, Any]]
) -> dict[str, dict[str, Any] | None]:
    """Return figures of every row; None where the method is not available."""
    return {name: None if row is None else figures(row) for name, row in rows.items()}


def _tables(world: str, log: GlassLog, rows: Mapping[str, Mapped | None]) -> list[dict[str, Any]]:
    """Return each length and angle of the world by each row, beside the truth and the paper."""
    solids = [s for s in log.solids() if s.is_at_height(float(log.laser_height))]
    entries = []
    for measure in load_world(world).measures:
        paper = PAPER[world][measure.name]
        for name, row in rows.items():
            value = row and measured(measure, solids, row.occupancy, row.glass)
            entries.append(
                {
                    "experiment": EXPERIMENT[world],
                    "name": measure.name,
                    "what": measure.doc,
                    "unit": measure.unit,
                    "method": name,
                    "true": measure.value,
                    "measured": value,
                    "error": None if value is None else value - measure.value,
                    "paper": paper,
                    "paper_error": paper - measure.value,
                }
            )
    return entries
