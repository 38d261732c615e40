"""A team on the simulated middle-size field, every robot with nodes of its own over DDS.

Images are drawn, markers found in them, each robot localized by landmarks alone and by its own
`team_localizer`; all drive in circles. Errors are against the simulator's true poses at the stamps
of what was published. Each robot is a process of three nodes; the simulator is another.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from _saying import saying
from experiments.live_team_graph import ROBOTS, run_graph
from floornav_common.arguments import positive
from floornav_common.reporting import Section, Table

SOURCES = {"alone": "landmark_pose", "team": "team_pose"}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument(
        "--duration", type=positive, default=30.0, metavar="S", help="simulated (30)"
    )
    parser.add_argument("--rate", type=positive, default=1.0, metavar="R", help="of real time (1)")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run the graph; fills `values["robots"]`, `values["mean"]` and `values["states"]`."""
    doing = f"{len(ROBOTS)} robots start, and drive for {args.duration:g} s ..."
    with saying(doing, is_quiet=args.quiet):
        heard = run_graph(args.duration, args.rate, args.seed, args.out_dir / "logs")
    values["robots"] = {
        name: {source: heard.errors(name, topic) for source, topic in SOURCES.items()}
        for name in ROBOTS
    }
    values["mean"] = {source: _mean(values["robots"], source) for source in SOURCES}
    values["states"] = heard.last_states
    values["images"] = heard.num_images
    return [_section(values)]


def _mean(robots: dict[str, Any], source: str) -> dict[str, float | None]:
    keys = ("mean_x_mm", "mean_y_mm", "mean_deg", "rms_m", "nees")
    found = {key: [robots[name][source][key] for name in robots] for key in keys}
    return {
        key: None if None in column else float(np.mean(column)) for key, column in found.items()
    }


def _section(values: dict[str, Any]) -> Section:
    rows = [
        [name, source, *(_cell(figures.get(key)) for key in _KEYS)]
        for name, robot in (values["robots"] | {"mean": values["mean"]}).items()
        for source, figures in robot.items()
    ]
    states = Table(
        ["what r1 says", "", "values"],
        [[part, text, told] for part, (text, told) in sorted(values["states"].items())],
    )
    return Section(
        "Live team", [__doc__ or "", Table(["robot", "by", *_HEADS], rows), states]
    )  # fmt: skip


_KEYS = ("poses", "mean_x_mm", "mean_y_mm", "mean_deg", "rms_m", "nees")
_HEADS = ("poses", "mean |dx| mm", "mean |dy| mm", "mean |dyaw| deg", "RMS m", "NEES (3)")


def _cell(value: float | None) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.3g}"
