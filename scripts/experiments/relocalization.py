"""A lost robot in a map that was made before: how often it is found, how soon, and never wrongly.

Random places in generated floors that a drive mapped; things have moved since. From each place the
robot drives on until it is found or has driven the way allowed; scans are rendered on the way, with
odometry that slips. `verified` is the node's own search. `first_look` takes the best place of the
same search at the first look and fits it, `brute` the best of all coarse poses as it is: what the
verification is worth. Found is a pose within 10 cm and 3 degrees, by where the mapping drive was
nearest; any other claim is a false one. Time is that of the computation, on one core, from the
first look to the claim; the way and the looks until then are told apart. *Seconds until found* are
those of the drive at 0.67 m/s and 1.3 rad/s with the computation on top, as if the robot stood
meanwhile.

`rough` and `carried` run the node's parts scan by scan at fewer places. `rough`: the robot is told
where it is, off by 0.5 m and 0.26 rad (deviations, which it is told too). `carried`: it is followed
in the map for 2 m, then carried to a place further off while its wheels stand, and drives on: when
does it say that it is lost, how long does it believe scans at a wrong pose before that, and when is
it found again.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.corridor_loop import slipping_odometry
from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.relocalization_figures import (
    HEAD,
    SENT_HEAD,
    Try,
    sent_cells,
    sent_figures,
    try_cells,
    try_figures,
)
from experiments.relocalization_floors import (
    FIRST_FLOOR,
    HERE,
    MappedFloor,
    look_at,
    mapped_floor,
    places,
    walk,
)
from experiments.relocalization_robot import STEP_S, Outcome, carried, is_right, rough
from floornav_common.arguments import count, natural, positive
from floornav_common.reporting import Progress, Section, Table
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.relocation_messages import Forget, Found, Look, NewMap
from grid_mapper.surface_points import points_of

NUM_MAPS, NUM_PLACES, WAY_M = 5, 200, 6.0
QUICK_MAPS, QUICK_PLACES = 2, 12
MORE_PLACES, QUICK_MORE = 40, 6
"""Places of `rough` and of `carried`, in all maps."""
METHODS = ("verified", "first_look", "brute")
SENT = {"rough": rough, "carried": carried}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    add = parser.add_argument
    add("--maps", type=count, metavar="N", help=f"floors ({NUM_MAPS})")
    add("--places", type=count, metavar="N", help=f"places in all of them ({NUM_PLACES})")
    add("--first", type=natural, metavar="N", help=f"number of the first floor ({FIRST_FLOOR})")
    add("--more", type=natural, metavar="N", help=f"places of rough and carried ({MORE_PLACES})")
    add("--way", type=positive, default=WAY_M, metavar="M", help="longest way, m (%(default)g)")
    add("--quick", action="store_true", help=f"{QUICK_MAPS} floors, {QUICK_PLACES} places")
    add_spread_options(parser, jobs=1)


@dataclass(frozen=True)
class Job:
    """What to do on one floor."""

    floor: int
    num_places: int
    num_more: int
    way_m: float


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Look for the robot everywhere; fills `methods` and the keys of the first."""
    jobs = _jobs(args)
    tries: dict[str, list[Try]] = {method: [] for method in METHODS}
    sent: dict[str, list[Outcome]] = {method: [] for method in SENT}
    rows = []
    with Progress("relocalization", len(jobs), is_quiet=args.quiet) as progress:
        done = run_tasks(on_floor, jobs, args.jobs, args.cluster)
        for k, (job, (found, outcomes)) in enumerate(done):
            for method in METHODS:
                tries[method] += found[method]
            for method in SENT:
                sent[method] += outcomes[method]
            rows.append([f"generated:{job.floor}", *try_cells(try_figures(found["verified"]))])
            progress.update(k + 1)
    values["methods"] = {method: try_figures(tries[method]) for method in METHODS}
    values["methods"] |= {method: sent_figures(sent[method]) for method in SENT}
    values["maps"], values["places"] = len(jobs), len(tries["verified"])
    verified = values["methods"]["verified"]
    values |= {k: verified[k] for k in ("found_share", "false_claims", "time_s")}
    values["misses"] = [vars(t) for t in tries["verified"] if not t.is_found]
    values["outcomes"] = {m: [vars(outcome) for outcome in sent[m]] for m in SENT}
    methods = [[m, *try_cells(values["methods"][m])] for m in METHODS]
    robots = Table(SENT_HEAD, [[m, *sent_cells(values["methods"][m])] for m in SENT])
    return [
        Section("Finding a lost robot", [__doc__ or "", Table(HEAD, methods)]),
        Section("Told about where it is, and carried off", [robots]),
        Section("Floor by floor, verified", [Table(HEAD, rows)]),
    ]


def _jobs(args: argparse.Namespace) -> list[Job]:
    """Return what to do on every floor."""
    num_maps = args.maps or (QUICK_MAPS if args.quick else NUM_MAPS)
    num_places = args.places or (QUICK_PLACES if args.quick else NUM_PLACES)
    num_more = args.more if args.more is not None else QUICK_MORE if args.quick else MORE_PLACES
    first = FIRST_FLOOR + 1000 * args.seed if args.first is None else args.first
    shares = zip(*(shared(num, num_maps) for num in (num_places, num_more)), strict=True)
    return [Job(first + k, *share, args.way) for k, share in enumerate(shares)]


def shared(num: int, among: int) -> list[int]:
    """Return how many of so many fall to each."""
    return [int(n) for n in np.diff(np.linspace(0, num, among + 1).round())]


def on_floor(job: Job) -> tuple[dict[str, list[Try]], dict[str, list[Outcome]]]:
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
    return tries, _sent(floor, job)


def _sent(floor: MappedFloor, job: Job) -> dict[str, list[Outcome]]:
    """Run the node's parts at further places."""
    outcomes: dict[str, list[Outcome]] = {}
    for number, (method, run_at) in enumerate(SENT.items()):
        starts = places(floor, job.num_more, np.random.default_rng((job.floor, 7, number)))
        rngs = (np.random.default_rng((job.floor, 7, number, k)) for k in range(job.num_more))
        outcomes[method] = [
            run_at(floor, start, job.way_m, rng) for start, rng in zip(starts, rngs, strict=True)
        ]
    return outcomes


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
            return _claim(floor, pose, answer.T_map_base, (spent, way, k * STEP_S, looks))
    return Try(None, False, spent, way, (len(poses) - 1) * STEP_S, looks)


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
        return Try(None, False, spent, 0.0, 0.0, 1)
    return _claim(floor, pose, found, (spent, 0.0, 0.0, 1))


def _claim(
    floor: MappedFloor, pose: SE2, claimed: SE2, spent: tuple[float, float, float, int]
) -> Try:
    true = floor.in_map(pose)
    return Try(true.between(claimed).distance, is_right(true, claimed), *spent)
