"""The team paper's experiment, 4.3, and what its method and ours come to beyond it.

Four robots on the paper's field (200 seeded layouts; those of Fig. 10 and 11 are not in the text),
bearings of 2, 3 and 4 degrees deviation; then 3 to 50 robots, other deviations, hiding, obstacles,
false and missing detections, poor rough poses, robots that lie. Bodies are 0.3 m wide and hide what
is behind them. Rough poses are drawn independently of the bearings (0.36 m along each axis, 15
degrees), but in the paper's cases, where they are method 1 on the very same bearings.

Values of the solver were chosen on layouts of seeds from 1000 on.
"""

from __future__ import annotations

import argparse
from typing import Any

from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.team_paper_cases import NOISES_DEG, fits_best, paper_case
from experiments.team_report import sections
from experiments.team_rows import ROWS, judged, num_layouts
from experiments.team_things import SIZES, judged_things
from experiments.team_triangles import every_triangle
from floornav_common.arguments import count
from floornav_common.reporting import Progress, Section
from floornav_common.ros.threads import limit_threads

NUM_LAYOUTS = 200
Task = tuple[str, float, range]  # table; noise, row or number of robots; seeds


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--layouts", type=count, default=NUM_LAYOUTS, metavar="N",
        help=f"layouts of the main rows; fewer of large teams (default: {NUM_LAYOUTS})",
    )  # fmt: skip
    add_spread_options(parser, jobs=1)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Judge all rows, write pictures, and return the report."""
    limit_threads(1)
    seeds = range(args.seed, args.seed + args.layouts)
    tables = ("paper_cases", "sweep", "variants", "faults", "published", "things", "every_triangle")
    values.update(layouts=args.layouts, best_noise_deg=None, **{key: [] for key in tables})
    num_steps = len(NOISES_DEG) + len(ROWS) + len(SIZES) + 1
    with Progress("team-localization", num_steps, is_quiet=args.quiet) as progress:
        tasks: list[Task] = [("paper_cases", noise_deg, seeds) for noise_deg in NOISES_DEG]
        tasks += [
            (row.table, k, seeds[: num_layouts(row, args.layouts)]) for k, row in enumerate(ROWS)
        ]
        tasks += [("things", num, seeds) for num in SIZES]
        done = run_tasks(_judged, tasks, args.jobs, args.cluster)
        for number, ((table, _, _), found) in enumerate(done, 1):
            values[table].append(found)
            progress.update(number, table.replace("_", " "))
        values["best_noise_deg"] = fits_best(values["paper_cases"])
        progress.update(num_steps, "every triangle", is_last=True)
        values["every_triangle"] = every_triangle(values["sweep"], args.seed)
    return sections(args.out_dir, values, args.seed)


def _judged(task: Task) -> dict[str, Any]:
    """Return the figures of one row of a table."""
    table, which, seeds = task
    limit_threads(1)
    if table == "paper_cases":
        return paper_case(which, seeds)
    if table == "things":
        return judged_things(int(which), seeds)
    return judged(ROWS[int(which)], seeds)
