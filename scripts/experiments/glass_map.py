"""Maps of worlds with glass: the glass paper's two experiments, and floors drawn by seed.

Rows: `overlay` is the paper's rule with key scans about as far apart as its stops; `laser` and
`sonar` are each alone; `bayes` is our second method; `range_layer` is the usual costmap layer for
sonars, over the laser's map. All see the same logs and the same poses. Glass found is judged over
the length of panes, in samples every 5 cm, more than 10 cm off anything opaque. Recall counts panes
within 2 m of the way that a sonar faced within its critical angle three times or more (`seen` is
their share of all glass). Precision is over the thinned lines of what a map says is glass beyond
the laser's obstacles. A false cell is occupied, farther than 10 cm from everything real; a phantom
is one that was seen through a pane, more than 15 cm behind it. Means are over floors.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

import numpy as np

from experiments.glass_floors import EXPERIMENT, Job, run_job
from experiments.glass_methods import NAMES
from experiments.glass_metrics import METRICS
from experiments.glass_report import sections
from experiments.parallel_tasks import add_spread_options, run_tasks
from floornav_common.arguments import natural
from floornav_common.reporting import Progress, Section

WORLDS = ("glass_corridor", "glass_wall")
SHARES = (0.2, 0.3, 0.4, 0.5)
NUM_LENGTH_SEEDS = 5
TURNS_RAD = (0.0, 0.3)
NUM_PAIRS = 200
NUM_DRAWN_FLOORS = 3
TO_REACH = {
    "glass_recall": 0.95, "false_occupied": 0.005, "phantom_share": 0.001, "length_error_m": 0.025,
}  # fmt: skip
_HIGH_IS_GOOD = ("glass_recall", "glass_precision", "glass_seen_share")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--floors", type=natural, default=30, metavar="N", help="drawn floors (30)")
    add_spread_options(parser)
    text = (
        "folder of sensor logs, used again if they are there (default: logs in the results); "
        "empty it when the simulator has changed"
    )
    parser.add_argument("--logs", type=Path, default=None, metavar="DIR", help=text)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Map all worlds; fills `values["tables"]`, `["methods"]`, `["paths"]` and `["worlds"]`."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before processes start
    jobs = _jobs(args)
    results: list[dict[str, Any]] = []
    lengths: list[dict[str, Any]] = []
    try:
        with Progress("glass-map", len(jobs), is_quiet=args.quiet) as progress:
            for _, result in run_tasks(run_job, jobs, min(args.jobs, len(jobs)), args.cluster):
                (lengths if "lengths" in result else results).append(result)
                progress.update(len(results) + len(lengths), result["world"])
    finally:
        _fill(values, results)
        values["lengths"] = length_spreads([e for r in lengths for e in r["lengths"]])
    return sections(values, results)


def _jobs(args: argparse.Namespace) -> list[Job]:
    floors = [f"generated:{args.seed + k}:{SHARES[k % len(SHARES)]:g}" for k in range(args.floors)]
    names = [*WORLDS, *floors]
    seeds = [args.seed] * len(WORLDS) + [args.seed + k for k in range(args.floors)]
    logs = args.out_dir / "logs" if args.logs is None else args.logs
    drawn = len(WORLDS) + NUM_DRAWN_FLOORS
    floors_jobs = [
        Job(
            world=name,
            seed=seed,
            logs=logs,
            num_pairs=NUM_PAIRS // len(names) + (k < NUM_PAIRS % len(names)),
            pairs_seed=seed,
            pictures=args.out_dir if k < drawn else None,
        )
        for k, (name, seed) in enumerate(zip(names, seeds, strict=True))
    ]
    length_jobs = [
        Job(world, args.seed + k, logs, 0, 0, None, turn)
        for world in WORLDS
        for k in range(NUM_LENGTH_SEEDS)
        for turn in TURNS_RAD
    ]
    return [*floors_jobs, *length_jobs]


def _fill(values: dict[str, Any], results: list[dict[str, Any]]) -> None:
    floors = [r for r in results if r["world"] not in EXPERIMENT]
    values["tables"] = [entry for result in results for entry in result.pop("tables")]
    values["methods"] = spreads(floors, "icp")
    values["methods_true_poses"] = spreads(floors, "true_poses")
    values["paths"] = path_sums(results, "paths")
    values["paths_behind_glass"] = path_sums(results, "paths_behind_glass")
    for name, sums in values["paths"].items():
        if values["methods"].get(name):
            values["methods"][name]["paths_through_glass"] = sums and sums["crossing"]
    values["reached"] = reached(values)
    values["worlds"] = results


def spreads(floors: list[dict[str, Any]], poses: str) -> dict[str, dict[str, Any] | None]:
    """Return mean, median and worst floor of every figure by row; None for a row without.

    Args:
        floors: Results of floors.
        poses: `icp` or `true_poses`.
    """
    names = [n for n in {n: None for f in floors for n in f[poses]} if n != ""]
    names.sort(key=lambda n: NAMES.index(n) if n in NAMES else len(NAMES))
    found: dict[str, dict[str, Any] | None] = {}
    for name in names:
        rows = [(f["world"], f[poses][name]) for f in floors if f[poses][name] is not None]
        found[name] = {} if rows else None
        for metric in METRICS if rows else ():
            found[name].update(_spread(metric, {w: row[metric] for w, row in rows}))  # type: ignore[union-attr]
    return found


def _spread(metric: str, by_world: dict[str, float]) -> dict[str, Any]:
    """Return a figure's mean, median and worst over the worlds that have it."""
    known = {world: value for world, value in by_world.items() if np.isfinite(value)}
    if not known:
        return {metric: None, f"{metric}_median": None, f"{metric}_worst": None}
    pick = min if metric in _HIGH_IS_GOOD else max
    worst = pick(known, key=lambda world: known[world])
    return {
        metric: float(np.mean(list(known.values()))),
        f"{metric}_median": float(np.median(list(known.values()))),
        f"{metric}_worst": known[worst],
        f"{metric}_worst_in": worst,
        f"{metric}_worlds": len(known),
    }


def length_spreads(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return each length and angle over seeds, by row and turn of the cells: how far it is off.

    `error_rms` and `error_worst` (signed) are over the seeds that have it in the map.
    """
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    keys = ("experiment", "name", "what", "unit", "method", "turn_rad", "true")
    for entry in entries:
        groups.setdefault(tuple(entry[key] for key in keys), []).append(entry)
    found = []
    for group, members in sorted(groups.items(), key=lambda item: str(item[0])):
        off = np.array([e["error"] for e in members if e["error"] is not None])
        found.append({
            **dict(zip(keys, group, strict=True)),
            "seeds": len(members),
            "in_map": len(off),
            "error_rms": float(np.sqrt(np.mean(off**2))) if len(off) else None,
            "error_worst": float(off[np.abs(off).argmax()]) if len(off) else None,
        })  # fmt: skip
    return found


def path_sums(results: list[dict[str, Any]], which: str) -> dict[str, dict[str, int] | None]:
    """Return the counts of A* paths by row, over all worlds; None for a row without maps.

    Args:
        results: Of worlds.
        which: `paths` or `paths_behind_glass`.
    """
    sums: dict[str, dict[str, int] | None] = {}
    for name in NAMES:
        counts = [r[which][name] for r in results if r[which].get(name) is not None]
        sums[name] = {k: sum(c[k] for c in counts) for k in counts[0]} if counts else None
    return sums


def reached(values: dict[str, Any]) -> dict[str, bool | None]:
    """Return whether `bayes` reached what is asked of it; None where there is nothing to tell."""
    row, paths = values["methods"].get("bayes"), values["paths"].get("bayes")
    mine = [e for e in values["tables"] if e["method"] == "bayes" and e["unit"] == "m"]
    off = [e["error"] for e in mine]
    told = {
        "lengths": all(e is not None and abs(e) <= TO_REACH["length_error_m"] for e in off)
        if off and any(e is not None for e in off) else None,
        "no_path_through_glass": None if paths is None else paths["crossing"] == 0,
    }  # fmt: skip
    if row and row["glass_recall"] is not None:
        told["glass_recall"] = row["glass_recall"] >= TO_REACH["glass_recall"]
    for name in ("false_occupied", "phantom_share"):
        if row and row[name] is not None:
            told[name] = row[name] <= TO_REACH[name]
    return told
