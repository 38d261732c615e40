"""Accuracy: one experiment with its table, figures and pictures; seeds are fixed and reported."""

from __future__ import annotations

import argparse
import importlib
import sys
import textwrap
from typing import Any

from _environment import ensure_environment

if __name__ == "__main__":
    ensure_environment(needs="node")

from floornav_common.reporting import (  # noqa: E402
    Section,
    Table,
    add_common_options,
    open_out_dir,
    run_command,
    say,
    summary,
    write_html,
)

EXPERIMENTS = {
    "laser-drives": "drift on simulated drives: full rate, key scans, slip, a bare corridor",
    "loop-drives": "laps round a simulated corridor before and after closing loops; false loops",
    "slam": "office floors with glass, loops and people before and after closing loops",
    "relocalization": "a lost robot in a map made before: found, how soon, false claims",
    "long-run": "lap after lap: memory, graph and time against the way driven",
    "determinism": "one recording mapped again and again, partly under load: the same bytes?",
    "sensor-models": "simulated sensors beside what their settings promise",
    "free-space": "polar free space beside the truth: cubes missed, phantoms, errors, templates",
    "free-space-odometry": "kiss-icp on free space that a camera saw, along a driven route: drift",
    "floor-images": "floor mask and free space on real pictures: --images DIR",
    "floor-localization": "pose from the floor's shape beside the paper's Table 1 and the bound",
    "velocity-avoidance": "driving round cubes with and without regard to velocity, seen by mirror",
    "sjmc-thesis": "chapter 5 of the SJMC thesis: things and people in the way, beside VFH+",
    "glass-map": "the glass paper's two places and drawn floors with glass, mapped by each method",
    "glass-drives": "driving on a map made on the way among glass: laser and sonars, laser only",
    "landmark-localization": "a robot alone by goal posts: methods 1 and 2 of the team paper",
    "live-team": "four simulated robots see each other, each with its own nodes: errors live",
    "team-localization": "the team paper: 4 robots, then 3 to 50, beside robots alone and bounds",
    "live-mapping": "a bag through replay and the live node beside map_bag: --bag BAG ...",
    "stereo-localization": "pose in a voxel map by stereo pairs beside the paper's; a drive",
    "stereo-matching": "disparities by DP beside OpenCV's: rendered pairs, or --pair LEFT RIGHT",
    "people-tracking": "people followed from scans beside the truth, and false movers",
    "crowd": "every planning method, ORCA and DWA among people who react: [--people FILE ...]",
    "faults": "what goes wrong in the running graph: safe, how soon it stands, how soon it drives",
    "soak": "the flat on a day for long: memory, exceptions, touches: [--minutes M]",
    "mrclam": "five real robots: bearings only, odometry, alone and as a team: --data DIR",
    "all": "all of them but faults and soak: at their --quick seeds, or --full",
}


def main(argv: list[str] | None = None) -> int:
    """Run one experiment, or all."""
    values, _ = run_experiment(sys.argv[1:] if argv is None else argv)
    return 0 if values["ok"] else 1


def run_experiment(argv: list[str]) -> tuple[dict[str, Any], list[Section]]:
    """Run one experiment, write its results and print them; returns its values and its report.

    Raises:
        UserError: On bad input.
    """
    args = _parsed(argv)
    module = _module(args.experiment)
    if hasattr(module, "check"):
        module.check(args)  # bad input leaves no folder behind
    args.out_dir = open_out_dir("evaluate", args.experiment, args.out)
    with summary(args.out_dir, command="evaluate", seed=args.seed, values={}) as values:
        values["experiment"] = args.experiment
        sections: list[Section] = module.run(args, values)
    title = f"floornav: {args.experiment}"
    write_html(args.out_dir, title, sections, f"seed {args.seed}")
    for section in sections:
        say(_section_text(section), is_quiet=args.quiet)
    say(f"results: {args.out_dir}", is_quiet=args.quiet)
    return values, sections


def _module(experiment: str):  # type: ignore[no-untyped-def]
    name = "whole_set" if experiment == "all" else experiment.replace("-", "_")
    return importlib.import_module(f"experiments.{name}")


def _section_text(section: Section) -> str:
    """Return a section's title, texts and tables for the terminal."""
    parts = [f"\n{section.title}"] if section.title else []
    for block in section.blocks:
        if isinstance(block, Table):
            parts.append(_as_text(block))
        elif isinstance(block, str):
            parts.append(textwrap.fill(block, 100))
    return "\n".join(parts)


def _as_text(table: Table) -> str:
    rows = [["-" if c is None else str(c) for c in row] for row in [table.header, *table.rows]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
    return "\n" + "\n".join(line.rstrip() for line in lines) + "\n"


def _parsed(argv: list[str]) -> argparse.Namespace:
    """Return the arguments; an experiment that is not named is not imported."""
    parser = argparse.ArgumentParser(prog="evaluate.py", description=__doc__)
    kinds = parser.add_subparsers(dest="experiment", metavar="EXPERIMENT", required=True)
    for name, text in EXPERIMENTS.items():
        kind = kinds.add_parser(name, help=text, description=text)
        seed = 0
        if name in argv:
            module = _module(name)
            module.add_options(kind)
            seed = getattr(module, "SEED", seed)
        add_common_options(kind, seed=seed)
    args, rest = parser.parse_known_args(argv)
    if rest:  # said with that experiment's own options
        kinds.choices[args.experiment].error(f"unrecognized arguments: {' '.join(rest)}")
    return args


if __name__ == "__main__":
    sys.exit(run_command(main))
