"""People followed from scans, beside the truth: errors, delays, switches, and false movers.

A robot roams through a hall of people who react to each other and to it, seen 1 m above the floor
(bodies, the thesis's URG-04LX) and at 0.3 m (legs that step, a laser of 541 beams), and through
worlds without people, where everything that is said to move is false. `office` has glass, in which
a laser sees a patch that goes along with the robot; the other worlds have none or little.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any

from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.tracking_drives import roam
from experiments.tracking_judge import TrackingJudge
from floornav_common.arguments import positive
from floornav_common.reporting import Progress, Section, Table, UserError
from sim_bridge.world import load_world
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import Obstacles
from sjmc_planner.tracking_config import TrackingConfig

SECONDS, QUICK_SECONDS = 120.0, 15.0
_SHOWN = {
    "seen_at_once": "seen at once", "followed": "followed",
    "velocity_error_m_s": "velocity m/s", "velocity_error_p90_m_s": "90 % m/s",
    "place_error_m": "place m", "nees_mean": "NEES (4)", "nees_median": "median (3.4)",
    "first_velocity_s": "first velocity s", "switches_per_person_minute": "switches / min",
    "false_movers_per_minute": "false movers / min",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A world, a robot, and how many people."""

    world: str
    model: str
    num_people: int = 0


CASES = {
    "bodies, 4 people": Case("crowd", "segway_urg", 4),
    "bodies, 12 people": Case("crowd", "segway_urg", 12),
    "legs, 4 people": Case("crowd", "segway_rmp50", 4),
    "legs, 12 people": Case("crowd", "segway_rmp50", 12),
    "nobody, furnished floor, 1 m": Case("furnished_floor", "segway_urg"),
    "nobody, furnished floor, 0.3 m": Case("furnished_floor", "segway_rmp50"),
    "nobody, flat with some glass": Case("flat", "segway_rmp50"),
    "nobody, office with glass fronts": Case("office", "segway_rmp50"),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--seconds", type=positive, default=SECONDS, metavar="S",
        help=f"simulated time of each drive (default: {SECONDS:g})",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SECONDS:g} s each only")
    add_spread_options(parser)


def check(args: argparse.Namespace) -> None:
    """Refuse bad input before a folder is made."""
    if not args.seconds > 1.0:
        raise UserError(f"--seconds must be > 1, got {args.seconds:g}")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Make all drives and return the report."""
    seconds = QUICK_SECONDS if args.quick else args.seconds
    values |= {"seconds_of_each": seconds, "cases": {}}
    tasks = [(case, seconds, args.seed) for case in CASES.values()]
    with Progress("people-tracking", len(CASES), is_quiet=args.quiet) as progress:
        followed = run_tasks(follow, tasks, args.jobs, args.cluster)
        for number, (name, (_, found)) in enumerate(zip(CASES, followed, strict=True)):
            values["cases"][name] = found
            progress.update(number + 1, name, is_last=number + 1 == len(CASES))
    rows = [
        [name, *(_cell(found[key]) for key in _SHOWN)] for name, found in values["cases"].items()
    ]
    return [Section("People followed from scans", [Table(["case", *_SHOWN.values()], rows)])]


def follow(task: tuple[Case, float, int]) -> dict[str, Any]:
    """Drive once and return the figures."""
    case, seconds, seed = task
    parameters = {"num_walkers": case.num_people} if case.num_people else None
    tracker, judge, last_s = PeopleTracker(TrackingConfig()), TrackingJudge(), 0.0
    for look in roam(load_world(case.world, parameters), case.model, seconds, seed):
        seen = Obstacles(look.scan, look.T_base_sensor)
        judge.note(look, tracker.update(seen, look.moved, look.time_s - last_s))
        last_s = look.time_s
    return judge.figures()


def _cell(value: Any) -> Any:
    return round(value, 2) if isinstance(value, float) else value
