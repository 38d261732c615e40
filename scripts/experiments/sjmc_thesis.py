"""Chapter 5 of the SJMC thesis with its robot and laser, and the section that it could not do.

Fig. 5.2 (time past a static obstacle against C) and 5.3 (against L_DANGER) for the published rule,
with VFH+ and our SJMC beside it; Fig. 5.5 (straight running past a person who crosses, against the
distance at which the person sets out); 5.2.4 (Stable people made to step aside), which the thesis
reports as not reached; Table 2.2 with the weaving of Fig. 2.10 counted. The text starts 2.7 m from
the obstacle, its speeds and times fit 4.7 m: both are run. Settings were chosen on other seeds
(1000 and on).
"""

from __future__ import annotations

import argparse
from typing import Any

from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.sjmc_thesis_aims import NEAREST_M, aims
from experiments.sjmc_thesis_bound import bound_rows
from experiments.sjmc_thesis_drives import (
    CROSSING,
    HALL,
    ONCOMING,
    PUBLISHED,
    SLIM,
    STANDING,
    STATIC,
    WAVEFRONT,
    Outcome,
    Task,
    run_task,
)
from experiments.sjmc_thesis_figures import (
    danger_rows,
    hall_rows,
    response_rows,
    stable_rows,
    static_figures,
    straight_rows,
)
from experiments.sjmc_thesis_report import sections
from floornav_common.arguments import count
from floornav_common.reporting import Progress, Section

STARTS = (2.7, 4.7)
RESPONSES = (2.1, 2.3, 2.5, 2.7, 2.9, 3.1, 3.3, 3.5, 3.7, 3.9)
DANGERS = (1.5, 1.7, 1.9, 2.1, 2.3)
CHOSEN = (2.7, 2.9, 3.1)  # of C, for Fig. 5.3
DISTANCES = (0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.7, 3.1, 3.5)
QUICK_DISTANCES = (1.3, 1.9, 2.7, 3.5)
METHODS = ("sjmc", PUBLISHED, "vfh_plus")
CROSSING_METHODS = (*METHODS, SLIM)
HALL_METHODS = (WAVEFRONT, "vff", "vfh", "vfh_plus", PUBLISHED, "sjmc")
PARTS = ("static", "crossing", "stable", "table")
NUM_OTHERS, NUM_RUNS, NUM_QUICK = 10, 50, 3
_FIRST_DANGER = 2.0  # m: of Fig. 5.2, before 5.3 chose 1.9 m


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--runs", type=count, default=NUM_RUNS, metavar="N",
        help=f"repetitions of sjmc with people, from {NEAREST_M:g} m on; all else {NUM_OTHERS} "
        f"at most (default: {NUM_RUNS})",
    )  # fmt: skip
    parser.add_argument(
        "--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART",
        help=f"only these of {', '.join(PARTS)}",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help=f"{NUM_QUICK} runs, few distances")
    add_spread_options(parser)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive everything, write pictures, and return the report."""
    tasks = tasks_of(args)
    done: dict[Task, Outcome] = {}
    with Progress("sjmc-thesis", len(tasks), is_quiet=args.quiet) as progress:
        for task, outcome in run_tasks(run_task, tasks, args.jobs, args.cluster):
            done[task] = outcome
            note = f"{len(done)} of {len(tasks)} drives, now {task.kind}"
            progress.update(len(done), note, is_last=len(done) == len(tasks))
            if len(done) % 20 == 0:
                fill(values, done)
    fill(values, done)
    return sections(args.out_dir, values, done)


def tasks_of(args: argparse.Namespace) -> list[Task]:
    """Return all drives that the options ask for."""
    num = NUM_QUICK if args.quick else args.runs
    distances = QUICK_DISTANCES if args.quick else DISTANCES
    found: list[Task] = []
    for part, make in (
        ("static", lambda k: _static_tasks(args.seed, k)),
        ("crossing", lambda k: _crossing_tasks(args.seed, k, distances)),
        ("stable", lambda k: _stable_tasks(args.seed, k)),
        ("table", lambda k: _hall_tasks(args.seed, k)),
    ):
        if part in args.parts:
            found += [t for k in range(num) for t in make(k) if k < NUM_OTHERS or _is_claimed(t)]
    return found


def _is_claimed(task: Task) -> bool:
    """Return whether shares are claimed of these runs, so that many are made."""
    is_far = task.kind != CROSSING or task.distance >= NEAREST_M
    return task.method == "sjmc" and task.kind in (CROSSING, STANDING, ONCOMING) and is_far


def _static_tasks(seed: int, k: int) -> list[Task]:
    found = [
        Task(STATIC, method, k, seed, distance=start)
        for start in STARTS
        for method in ("sjmc", "vfh_plus")
    ]
    for start in STARTS:
        pairs = {(c, _FIRST_DANGER) for c in RESPONSES} | {(c, d) for c in CHOSEN for d in DANGERS}
        found += [
            Task(STATIC, PUBLISHED, k, seed, distance=start, response=c, danger=d)
            for c, d in sorted(pairs)
        ]
    return found


def _crossing_tasks(seed: int, k: int, distances: tuple[float, ...]) -> list[Task]:
    return [Task(CROSSING, m, k, seed, distance=d) for d in distances for m in CROSSING_METHODS]


def _stable_tasks(seed: int, k: int) -> list[Task]:
    return [
        Task(kind, m, k, seed, is_yielding=yields)
        for kind in (STANDING, ONCOMING)
        for yields in (True, False)
        for m in METHODS
    ]


def _hall_tasks(seed: int, k: int) -> list[Task]:
    return [
        Task(HALL, m, k, seed, density=density, is_dynamic=dynamic)
        for density in ("low", "high")
        for dynamic in (False, True)
        for m in HALL_METHODS
    ]


def fill(values: dict[str, Any], done: dict[Task, Outcome]) -> None:
    """Write what is known so far."""
    values["fig5_2"] = response_rows(done, _FIRST_DANGER)
    values["fig5_3"] = danger_rows(done, CHOSEN)
    values["fig5_5"] = straight_rows(done)
    values["fig5_5_bound"] = bound_rows(sorted({t.distance for t in done if t.kind == CROSSING}))
    values["table2_2"] = hall_rows(done)
    values["stable"] = {
        **stable_rows(done, STANDING, "sjmc"),
        "methods": {m: stable_rows(done, STANDING, m) for m in METHODS},
        "oncoming": {m: stable_rows(done, ONCOMING, m) for m in METHODS},
    }
    values["static"] = static_figures(done)
    ratios = [row["ratio"] for row in values["static"].values() if row["ratio"] is not None]
    values["static_time_ratio"] = max(ratios, default=None)
    values["aims"] = aims(values)
