"""Driving among glass on a map that the robot makes on the way: laser and sonars, or laser alone.

The robot (Segway RMP 50, laser, 16 sonars, 0.6 m/s) starts in a place that it does not know, rooms
and offices with glass walls and doors drawn by seed, and drives to a goal behind glass and on to
one beside a pane. It maps while it drives as `grid_mapper` does, `wavefront_planner` gives the way
over this map, and a method of `local_planner` follows it. It knows scans, echoes and odometry whose
wheels slip. The truth judges: a run ends with the first touch of anything. Glass is panes and the
frames that hold them. Time and path ratio (way driven over the shortest true one) are medians over
the runs that reached both goals.

Rows: `sjmc` and `vfh_plus` mind the glass of the map and echoes from close by, as the node does;
`path only`: they mind the scan alone, and only the way knows of glass; `laser only`: no sonars.
Values were chosen on seed 1000 and on the second place of seed 0: so seed 1 is the default here.
"""

from __future__ import annotations

import argparse
from typing import Any

from experiments.glass_drives_pictures import draw_runs
from experiments.glass_drives_runs import LIMIT_S, ROWS, Outcome, Task, figures, run_task
from experiments.glass_drives_worlds import place_of
from experiments.parallel_tasks import add_spread_options, run_tasks
from floornav_common.arguments import count
from floornav_common.reporting import Picture, Progress, Section, Table

NUM_RUNS, NUM_OTHERS, NUM_QUICK, NUM_PICTURED = 50, 20, 2, 4
CLAIMED = ("sjmc", "vfh_plus")
SEED = 1  # the default; values were chosen on a place of seed 0
_SHOWN = {
    "runs": "runs", "touched_glass": "touched glass", "touched_things": "other things",
    "reached": "both goals", "goals_reached": "goals", "time_s": "time s",
    "path_ratio": "path / shortest", "least_glass_m": "least to glass m",
    "pose_error_max_m": "pose off m (worst)",
}  # fmt: skip


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--runs", type=count, default=NUM_RUNS, metavar="N",
        help=f"runs of {' and '.join(CLAIMED)} (default: {NUM_RUNS}); {NUM_OTHERS} of others",
    )  # fmt: skip
    parser.add_argument(
        "--quick", action="store_true", help=f"{NUM_QUICK} runs of each only, to try it out"
    )
    parser.add_argument(
        "--rows", nargs="+", choices=tuple(ROWS), default=list(ROWS), metavar="ROW",
        help=f"which (default: all: {'; '.join(ROWS)})",
    )  # fmt: skip
    add_spread_options(parser)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Make all runs, write pictures, and return the report.

    Fills `values["runs_of_each"]`, `["limit_s"]`, `["rows"]` by name with the keys of `figures`,
    and `["touches"]`: number, row, kind of place and what was touched, of each run that touched.
    """
    num = NUM_QUICK if args.quick else args.runs
    values.update(runs_of_each=num, limit_s=LIMIT_S, rows={}, touches=[])
    tasks = [
        Task(number, row, args.seed)
        for number in range(num)
        for row in args.rows
        if number < NUM_OTHERS or row in CLAIMED
    ]
    outcomes: dict[Task, Outcome] = {}
    with Progress("glass-drives", len(tasks), is_quiet=args.quiet) as progress:
        for task, outcome in run_tasks(run_task, tasks, args.jobs, args.cluster):
            outcomes[task] = outcome
            _fill(values, outcomes, args.rows)
            touched = sum(o.touched == "glass" for o in outcomes.values())
            note = f"{len(outcomes)} of {len(tasks)} runs, {touched} touched glass"
            progress.update(len(outcomes), note, is_last=len(outcomes) == len(tasks))
    return _sections(args, values, outcomes)


def _fill(values: dict[str, Any], outcomes: dict[Task, Outcome], rows: list[str]) -> None:
    values["rows"] = {
        row: figures([o for t, o in outcomes.items() if t.row == row]) for row in rows
    }
    values["touches"] = [
        {"number": t.number, "row": t.row, "kind": o.kind, "touched": o.touched}
        for t, o in outcomes.items()
        if o.touched
    ]


def _sections(
    args: argparse.Namespace, values: dict[str, Any], outcomes: dict[Task, Outcome]
) -> list[Section]:
    rows = [[name, *(_cell(own[key]) for key in _SHOWN)] for name, own in values["rows"].items()]
    table = Table(["row", *_SHOWN.values()], rows)
    pictures = []
    for number in range(min(NUM_PICTURED, values["runs_of_each"])):
        runs = {t.row: o for t, o in outcomes.items() if t.number == number}
        path = args.out_dir / f"run_{number}.png"
        draw_runs(path, place_of(args.seed, number), runs)
        text = (
            f"Run {number}: light blue is glass, red what the robot's map holds for glass at the "
            "end, blue its outline every second; + are the goals."
        )
        pictures.append(Picture(path, text))
    return [Section("Driving among glass", [__doc__ or "", table, *pictures])]


def _cell(value: Any) -> Any:
    return round(value, 2) if isinstance(value, float) else value
