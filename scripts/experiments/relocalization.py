"""A lost robot in a map that was made before: how often it is found, how soon, and never wrongly.

Random places in generated floors that a drive mapped; things have moved since. From each place the
robot drives on until it is found or has driven the way allowed; scans are rendered on the way, with
odometry that slips. `verified` is the node's own search. `first_look` takes the best place of the
same search at the first look and fits it, `brute` the best of all coarse poses as it is: what the
verification is worth. Found is a pose within 10 cm and 3 degrees, by where the mapping drive was
nearest; any other claim is a false one. Time is that of the computation, on one core, from the
first look to the claim; the way and the looks until then are told apart.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.corridor_loop import slipping_odometry
from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.relocalization_floors import (
    FIRST_FLOOR,
    HERE,
    MappedFloor,
    look_at,
    mapped_floor,
    places,
    walk,
)
from floornav_common.reporting import Progress, Section, Table
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.relocation_messages import Forget, Found, Look, NewMap
from grid_mapper.surface_points import points_of

NUM_MAPS, NUM_PLACES, WAY_M = 5, 200, 6.0
QUICK_MAPS, QUICK_PLACES = 2, 12
NEAR_M, NEAR_RAD = 0.10, np.deg2rad(3.0)
METHODS = ("verified", "first_look", "brute")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    add = parser.add_argument
    add("--maps", type=int, metavar="N", help=f"floors ({NUM_MAPS})")
    add("--places", type=int, metavar="N", help=f"places in all of them ({NUM_PLACES})")
    add("--way", type=float, default=WAY_M, metavar="M", help="longest way, m (%(default)g)")
    add("--quick", action="store_true", help=f"{QUICK_MAPS} floors, {QUICK_PLACES} places")
    add_spread_options(parser, jobs=1)


@dataclass(frozen=True)
class Job:
    """What to do on one floor."""

    floor: int
    num_places: int
    way_m: float


@dataclass(frozen=True)
class Try:
    """What a method said of a place.

    Attributes:
        error_m: Of the pose claimed; None without a claim.
        error_rad: Of its yaw.
        time_s: Computing time of all looks.
        way_m: Driven before.
        looks: Scans looked at.
    """

    error_m: float | None
    error_rad: float | None
    time_s: float
    way_m: float
    looks: int

    @property
    def is_found(self) -> bool:
        """Whether the pose is near enough."""
        if self.error_m is None or self.error_rad is None:
            return False
        return self.error_m <= NEAR_M and self.error_rad <= NEAR_RAD

    @property
    def is_false(self) -> bool:
        """Whether another was claimed."""
        return self.error_m is not None and not self.is_found


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Look for the robot everywhere; fills `methods` and the keys of the first."""
    num_maps = args.maps or (QUICK_MAPS if args.quick else NUM_MAPS)
    num_places = args.places or (QUICK_PLACES if args.quick else NUM_PLACES)
    shares = np.diff(np.linspace(0, num_places, num_maps + 1).round().astype(int)).tolist()
    first = FIRST_FLOOR + 1000 * args.seed
    jobs = [Job(first + k, share, args.way) for k, share in enumerate(shares)]
    tries: dict[str, list[Try]] = {method: [] for method in METHODS}
    rows = []
    with Progress("relocalization", num_maps, is_quiet=args.quiet) as progress:
        for k, (job, found) in enumerate(run_tasks(on_floor, jobs, args.jobs, args.cluster)):
            for method in METHODS:
                tries[method] += found[method]
            rows.append([f"generated:{job.floor}", *_cells(_figures(found["verified"]))])
            progress.update(k + 1)
    values["methods"] = {method: _figures(tries[method]) for method in METHODS}
    values["maps"], values["places"] = num_maps, num_places
    verified = values["methods"]["verified"]
    values |= {k: verified[k] for k in ("found_share", "false_claims", "time_s")}
    values["misses"] = [vars(t) for t in tries["verified"] if not t.is_found]
    header = ["", "places", "found", "false claims", "time s", "p90 s", "way m", "p90 m", "error m"]
    methods = [[m, *_cells(values["methods"][m])] for m in METHODS]
    return [
        Section("Finding a lost robot", [__doc__ or "", Table(header, methods)]),
        Section("Floor by floor, verified", [Table(header, rows)]),
    ]


def on_floor(job: Job) -> dict[str, list[Try]]:
    """Map one floor and look for the robot at its places."""
    floor = mapped_floor(job.floor)
    starts = places(floor, job.num_places, np.random.default_rng((job.floor, 5)))
    relocalizer = Relocalizer(GridMapperConfig())
    relocalizer.take(NewMap(floor.grid))
    tries: dict[str, list[Try]] = {method: [] for method in METHODS}
    for k, start in enumerate(starts):
        rng = np.random.default_rng((job.floor, 5, k))  # each place by itself can be had again
        poses = walk(floor, start, job.way_m, rng)
        odometry = slipping_odometry(poses, int(rng.integers(1 << 30)))
        tries["verified"].append(_verified(relocalizer, floor, poses, odometry, rng))
        for method in METHODS[1:]:
            tries[method].append(_at_once(relocalizer, floor, start, rng, method == "brute"))
    return tries


def _verified(
    relocalizer: Relocalizer, floor: MappedFloor, poses: list[SE2], odometry: list[SE2],
    rng: np.random.Generator,
) -> Try:  # fmt: skip
    """Drive on until the robot is found."""
    relocalizer.take(Forget())
    config, last = GridMapperConfig().relocation, None
    spent, way, looks = 0.0, 0.0, 0
    for k, (pose, odom) in enumerate(zip(poses, odometry, strict=True)):
        way += poses[k - 1].between(pose).distance if k else 0.0
        moved = SE2(9.0, 0.0, 0.0) if last is None else last.between(odom)
        if moved.distance < config.look_distance_m and abs(moved.yaw) < config.look_turn_rad:
            continue
        last, looks = odom, looks + 1
        look = Look(k, look_at(floor.now, pose, rng), HERE, odom)
        started = time.process_time()
        answer = relocalizer.take(look)
        spent += time.process_time() - started
        if isinstance(answer, Found):
            return _claim(floor, pose, answer.T_map_base, spent, way, looks)
    return Try(None, None, spent, way, looks)


def _at_once(
    relocalizer: Relocalizer, floor: MappedFloor, pose: SE2, rng: np.random.Generator,
    is_brute: bool,
) -> Try:  # fmt: skip
    """Take the best place at the first look, as the search has it, or fitted too."""
    scan = look_at(floor.now, pose, rng)
    started = time.process_time()
    points = points_of(scan, HERE, GridMapperConfig().matcher)
    found = relocalizer.best_at_once(points, is_fitted=not is_brute)
    spent = time.process_time() - started
    if found is None:
        return Try(None, None, spent, 0.0, 1)
    return _claim(floor, pose, found, spent, 0.0, 1)


def _claim(
    floor: MappedFloor, pose: SE2, claimed: SE2, time_s: float, way_m: float, looks: int
) -> Try:
    off = floor.in_map(pose).between(claimed)
    return Try(off.distance, abs(off.yaw), time_s, way_m, looks)


def _figures(tries: list[Try]) -> dict[str, Any]:
    """Return the figures of a method; medians are of the places found."""
    found = [t for t in tries if t.is_found]

    def quantile(values: list[float], share: float) -> float | None:
        return float(np.quantile(values, share)) if values else None

    return {
        "places": len(tries),
        "found_share": len(found) / max(1, len(tries)),
        "false_claims": sum(t.is_false for t in tries),
        "time_s": quantile([t.time_s for t in found], 0.5),
        "time_s_p90": quantile([t.time_s for t in found], 0.9),
        "way_m": quantile([t.way_m for t in found], 0.5),
        "way_m_p90": quantile([t.way_m for t in found], 0.9),
        "error_m": quantile([t.error_m for t in found if t.error_m is not None], 0.5),
        "looks": quantile([float(t.looks) for t in found], 0.5),
    }


def _cells(f: dict[str, Any]) -> list[str]:
    keys = ("time_s", "time_s_p90", "way_m", "way_m_p90", "error_m")
    rest = ["-" if f[key] is None else f"{f[key]:.3f}" for key in keys]
    return [str(f["places"]), f"{100 * f['found_share']:.1f} %", str(f["false_claims"]), *rest]
