"""Office floors with glass, loops and people: poses and maps before and after closing loops.

Floors are the generator's with a ring of corridors, held out from setting any value or rule (those
were worked out on floors below 7500); each is driven twice round (about 150 m) past people who walk
to and fro. Odometry slips: each wheel's radius is
off by 0.3 % (deviation), 1 % of the way is lost with a deviation of 2 %. Where the robot stands
against somebody who does not make room, its wheels spin (`spun s`: for how long odometry ran ahead
of the truth by over 0.1 m/s): up to 4 m in 5 s, far beyond that slip. Laser as the URG-04LX:
240 degrees, to 4 m, 1 cm and 1 % noise, 5 Hz; 16 sonars. Rows: `before` is the front end that loop
closing starts from, `after` its poses corrected by the graph; `all_scans` is `loop_closing: false`;
`odometry` and `kiss_icp` (scans alone) are peers, `true_poses` maps at the true poses: the best
that these sensors allow. In `after_false_loops` six wrong loops that claim 2 cm are slipped in on
the way: half a meter along the robot's way, where it is back after a lap and again later; two
places over 5 m apart said to be one; a place said to be 1 m beside where it is; a pair of the far
kind that agree with each other. `false_loops_accepted` counts those that the graph kept, and loops
that it found itself, with these slipped in and without, off by more than 0.3 m or 5 degrees. ATE
after the best rigid alignment, which maps are laid by too; RPE from scan to scan; IoU of occupied
cells and true surfaces, a cell (5 cm) beside counted as the same; recall of the glass that a sonar
faced three times or more. Median over floors with quartiles; ground truth only judges. `--floors`
drives floors by number, as those on which values were set: 7003 to 7027.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

import numpy as np

from experiments import consistency
from experiments.parallel_tasks import add_spread_options, run_tasks
from experiments.slam_drives import floor_names
from experiments.slam_runs import FIGURES, METHODS, Job, run_floor
from floornav_common.arguments import count
from floornav_common.reporting import Picture, Progress, Section, Table, UserError
from grid_mapper.config import GridMapperConfig
from sim_bridge.world import load_world

NUM_QUICK = 2
NUM_PICTURES = 3
DIGITS = {"ate_m": 3, "rpe_m": 4, "map_iou": 3, "glass_recall": 3}
HIGH_IS_GOOD = ("map_iou", "glass_recall")
HEADS = {"ate_m": "ATE m", "rpe_m": "RPE m", "map_iou": "map IoU", "glass_recall": "glass recall"}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    add = parser.add_argument
    add("--worlds", type=count, default=20, metavar="N", help="floors (20)")
    add("--quick", action="store_true", help=f"{NUM_QUICK} floors")
    text = "these floors instead, by number and share of glass, such as 7003:0.2"
    add("--floors", nargs="+", metavar="N:SHARE", help=text)
    add_spread_options(parser, jobs=1)
    text = "folder of drives, used again if they are there (default: logs in the results)"
    add("--logs", type=Path, default=None, metavar="DIR", help=text)


def check(args: argparse.Namespace) -> None:
    """Refuse numbers that make no sense.

    Raises:
        UserError: They do not.
    """
    for name in args.floors or ():
        try:
            load_world(f"generated:{name}")
        except ValueError as error:
            raise UserError(f"--floors: {error}") from error


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive and map all floors; fills `values["methods"]` and what is counted."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before processes start
    logs = args.out_dir / "logs" if args.logs is None else args.logs
    names = [f"generated:{name}" for name in args.floors or ()]
    names = names or floor_names(NUM_QUICK if args.quick else args.worlds, args.seed)
    jobs = [
        Job(name, int(name.split(":")[1]), logs, args.out_dir if k < NUM_PICTURES else None)
        for k, name in enumerate(names)
    ]
    results: list[dict[str, Any]] = []
    try:
        with Progress("slam", len(jobs), is_quiet=args.quiet) as progress:
            for job, result in run_tasks(run_floor, jobs, min(args.jobs, len(jobs)), args.cluster):
                results.append(result)
                progress.update(len(results), job.world)
    finally:
        fill(values, results)
    return sections(values, results)


def fill(values: dict[str, Any], results: list[dict[str, Any]]) -> None:
    """Put all figures where the summary has them."""
    values["methods"] = {name: spreads(results, name) for name in METHODS}
    counts = ("found", "injected", "kept", "led_to")
    values["false_loops"] = {c: sum(r[f"false_loops_{c}"] for r in results) for c in counts}
    values["loops"] = sum(r["loops"] for r in results)
    accepted = ("found", "kept", "led_to")
    values["false_loops_accepted"] = sum(values["false_loops"][count] for count in accepted)
    values["nees"] = consistency.pooled([r["nees"] for r in results], GridMapperConfig().loop)
    values["worlds"] = results


def spreads(results: list[dict[str, Any]], method: str) -> dict[str, float | str | None]:
    """Return every figure of a method: median, quartiles, worst, and the floor of that."""
    found: dict[str, float | str | None] = {}
    for key in FIGURES:
        known = [(r["methods"][method][key], r["world"]) for r in results]
        known = [(v, world) for v, world in known if v is not None and np.isfinite(v)]
        if not known:
            found.update(dict.fromkeys((key, *(f"{key}_{s}" for s in ("low", "high", "worst")))))
            continue
        low, median, high = np.quantile([v for v, _ in known], (0.25, 0.5, 0.75)).tolist()
        worst = (min if key in HIGH_IS_GOOD else max)(known)
        found |= {key: median, f"{key}_low": low, f"{key}_high": high}
        found |= {f"{key}_worst": worst[0], f"{key}_worst_in": worst[1]}
    return found


def sections(values: dict[str, Any], results: list[dict[str, Any]]) -> list[Section]:
    """Return the report: methods, loops, floors, pictures."""
    head = ["method", *(f"{HEADS[key]}: median (quartiles), worst" for key in FIGURES)]
    rows = [[name, *(_cell(values["methods"][name], key) for key in FIGURES)] for name in METHODS]
    false = values["false_loops"]
    counts = (
        f"{len(results)} floors, {values['loops']} loops closed, {false['found']} of them wrong; "
        f"of {false['injected']} wrong loops slipped in the graph kept {false['kept']}, and with "
        f"them it closed {false['led_to']} wrong ones itself."
    )
    floors = Table(
        [
            "floor",
            "way m",
            "spun s",
            "nodes",
            "loops",
            "wrong",
            "ATE before",
            "ATE after",
            "IoU before",
            "IoU after",
        ],
        [_floor_row(result) for result in results],
    )
    nees = [consistency.__doc__ or "", consistency.table({"all floors": values["nees"]})]
    pictures = [Picture(Path(p), r["world"]) for r in results for p in r["pictures"]]
    return [
        Section("Before and after closing loops", [__doc__ or "", Table(head, rows), counts]),
        Section("Floors", [floors]),
        Section("Whether uncertainties are true", nees),
        Section("Maps", ["Walls black, glass red, panes blue lines.", *pictures]),
    ]


def _cell(figures: dict[str, Any], key: str) -> str:
    if figures[key] is None:
        return "-"
    low, median, high, worst = (
        f"{figures[name]:.{DIGITS[key]}f}"
        for name in (f"{key}_low", key, f"{key}_high", f"{key}_worst")
    )
    return f"{median} ({low} to {high}), {worst}"


def _floor_row(result: dict[str, Any]) -> list[str]:
    before, after = result["methods"]["before"], result["methods"]["after"]
    counts = [f"{result['way_m']:.0f}", f"{result['spun_s']:.0f}", str(result["nodes"])]
    counts += [str(result["loops"]), str(result["false_loops_found"])]
    errors = [f"{row['ate_m']:.3f}" for row in (before, after)]
    return [result["world"], *counts, *errors, *(f"{r['map_iou']:.3f}" for r in (before, after))]
