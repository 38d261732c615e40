"""Lap after lap round a simulated corridor: memory, graph and time against the way driven.

The drive is that of `loop-drives` (66 m a lap, each up to 0.4 m beside the others, key scans of 180
beams, odometry that slips by up to 10 %), localized with loops closed as it comes. *Key scans* are
what the graph keeps to compare places: of each place (half a meter, about one way) at most
`loop.max_scans_a_place`. Nodes whose scans are gone become part of others: *free nodes* are what
the graph is solved for, and they and the loops between them are bounded too. What grows with the
way is where every node and scan was; *process* is all memory held, the simulated scans, which are
made as they are needed, left out. Hours are at `--speed`.
"""

from __future__ import annotations

import argparse
import resource
import time
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.corridor_loop import ring_laps, slipping_odometry
from floornav_common.arguments import count, positive
from floornav_common.reporting import Progress, Section, Table, UserError
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.loop_warm_up import warm_up_loops
from grid_mapper.trajectory_metrics import trajectory_errors

FIRST_SEED = 300
SCANS_A_LAP = 150
STEP_NS = 400_000_000
HERE = SE2.identity()
KEYS = ("way_m", "hours", "nodes", "free_nodes", "loops", "scans_kept", "key_scans_mb",
        "process_mb", "ms_a_scan", "ms_max", "ate_m")  # fmt: skip


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    add = parser.add_argument
    add("--laps", type=count, default=40, metavar="N", help="laps (40)")
    add("--speed", type=positive, default=0.5, metavar="M_S", help="at which hours count (0.5 m/s)")
    most = GridMapperConfig().loop.max_scans_a_place
    add("--scans-a-place", type=count, default=most, metavar="N",
        help=f"loop.max_scans_a_place ({most})")  # fmt: skip


def check(args: argparse.Namespace) -> None:
    """Refuse numbers that make no sense.

    Raises:
        UserError: They do not.
    """
    if args.scans_a_place < 2:
        raise UserError(f"--scans-a-place must be >= 2, got {args.scans_a_place}")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive the laps; fills `values["laps"]`, a row for each."""
    values["laps"] = rows = []
    default = GridMapperConfig()
    loop = replace(default.loop, max_scans_a_place=args.scans_a_place)
    warm_up_loops()
    laps = _Laps(replace(default, loop=loop), args.seed)
    with Progress("long-run", args.laps, is_quiet=args.quiet) as progress:
        for number in range(args.laps):
            rows.append(laps.drive(number, args.speed))
            progress.update(number + 1, f"{rows[-1]['nodes']} nodes")
    table = [[f"{row[key]:.3g}" if isinstance(row[key], float) else str(row[key]) for key in KEYS]
             for row in rows]  # fmt: skip
    return [Section("Laps", [__doc__ or "", Table([key.replace("_", " ") for key in KEYS], table)])]


class _Laps:
    """Drives a lap at a time, so that the scans of one are held."""

    def __init__(self, config: GridMapperConfig, seed: int) -> None:
        self._localizer, self._seed = LoopClosingLocalizer(config), FIRST_SEED + seed
        self._truth: list[SE2] = []
        self._odom = SE2.identity()

    def drive(self, number: int, speed: float) -> dict[str, Any]:
        """Drive a lap; return how things are behind it."""
        walls_seed, rng = self._seed, np.random.default_rng((self._seed, number))
        lap = ring_laps(180, np.pi, walls_seed, SCANS_A_LAP, 1, rng)
        odometry = slipping_odometry([*self._truth[-1:], *lap.truth], self._seed)
        odometry = odometry[1:] if self._truth else odometry
        first = self._truth[-1] if self._truth else lap.truth[0]
        ms = []
        for scan, pose, odom in zip(lap.scans, lap.truth, odometry, strict=True):
            started = time.process_time()
            T_odom_base = self._odom @ first.between(odom)
            stamp_ns = len(self._truth) * STEP_NS
            self._localizer.insert_scan(stamp_ns, scan, HERE, T_odom_base)
            ms.append(1e3 * (time.process_time() - started))
            self._truth.append(pose)
        self._odom = self._odom @ first.between(odometry[-1])
        return self._state(ms, speed)

    def _state(self, ms: list[float], speed: float) -> dict[str, Any]:
        closer = self._localizer.closer
        poses = [known.T_map_base for known in self._localizer.known_poses()]
        stamped = [list(enumerate(track)) for track in (poses, self._truth)]
        pairs = zip(self._truth, self._truth[1:], strict=False)
        way = sum(a.between(b).distance for a, b in pairs)
        num, size = key_scans(closer)
        return {
            "way_m": way, "hours": way / speed / 3600.0, "nodes": len(closer.frames),
            "free_nodes": closer.num_free, "loops": closer.num_loops,
            "scans_kept": num, "key_scans_mb": size / 1e6,
            "process_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10,
            "ms_a_scan": float(np.mean(ms)), "ms_max": max(ms),
            "ate_m": trajectory_errors(*stamped, tolerance_ns=0).ate,
        }  # fmt: skip


def key_scans(closer: LoopCloser) -> tuple[int, int]:
    """Return how many key scans a graph holds, and their bytes."""
    held = [frame for frame in closer.frames if len(frame.points)]
    arrays = [
        array
        for frame in held
        for array in (frame.points.points, frame.points.covs, frame.points.normals,
                      frame.scan.ranges)
    ]  # fmt: skip
    return len(held), sum(array.nbytes for array in arrays)
