"""A demo on the middle-size field: four robots that locate each other by bearings.

Each is a process of its own (`marker_detector`, `landmark_localizer`, `team_localizer` composed),
the simulator another. The robots drive in circles; a script says so, no planner.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from _demo_pictures import write_overview
from _processes import ChildDiedError
from _saying import saying
from experiments.live_team import SOURCES
from experiments.live_team_graph import ROBOTS, Heard, run_graph
from floornav_common.reporting import Figures, Picture, Section, Table, write_html
from sim_bridge.simulation import Simulation
from sim_bridge.world import World

DEFAULT_S = 20.0
_KEYS = (
    ("poses", "poses"), ("mean_x_mm", "mean |dx| [mm]"), ("mean_y_mm", "mean |dy| [mm]"),
    ("mean_deg", "mean |dyaw| [deg]"), ("rms_m", "RMS [m]"),
)  # fmt: skip


class Field:
    """One run.

    Args:
        world: The field.
        args: The command line.
        out: The result folder.
        has_window: Not used: the simulator has no window here.
    """

    def __init__(self, world: World, args: argparse.Namespace, out: Path, has_window: bool) -> None:
        self.problem = "stopped before the end"
        self._world, self._args, self._out = world, args, out
        self._heard: Heard | None = None
        self._wall_s = 0.0

    def run(self) -> None:
        """Start everything, let the robots drive, stop everything."""
        duration, started = self._args.duration or DEFAULT_S, time.monotonic()
        text = f"starting the simulator and {len(ROBOTS)} robots, who drive for {duration:g} s ..."
        try:
            with saying(text, is_quiet=self._args.quiet):
                logs = self._out / "logs"
                self._heard = run_graph(duration, self._args.rtf, self._args.seed, logs)
            self.problem = ""
        except (ChildDiedError, RuntimeError) as error:
            self.problem = str(error)
        self._wall_s = time.monotonic() - started

    def results(self) -> dict[str, Any]:
        """Return this run's keys of the summary."""
        heard, problem = self._heard, {"problem": self.problem} if self.problem else {}
        if heard is None:
            return problem
        errors = {
            name: {source: heard.errors(name, topic) for source, topic in SOURCES.items()}
            for name in ROBOTS
        }
        return {
            "sim_s": heard.time_s,
            "pose_error_m": errors,
            "images": heard.num_images,
            **problem,
        }

    def write(self, values: dict[str, Any]) -> None:
        """Write the picture and the page."""
        simulation = Simulation(self._world, seed=self._args.seed)
        write_overview(self._out / "world.png", simulation.overview())
        simulation.close()
        rows = [
            [name, source, *(_cell(figures[key]) for key, _ in _KEYS)]
            for name, robot in (values["pose_error_m"] or {}).items()
            for source, figures in robot.items()
        ]
        state = (self.problem.splitlines()[0], "bad") if self.problem else ("done", "good")
        shown = Figures([("result", *state), ("simulated", f"{values['sim_s'] or 0.0:.1f} s")])
        table = Table(["robot", "by", *(head for _, head in _KEYS)], rows)
        text = (
            "alone: by the bearings of the goals; team: by those of the teammates too. The floor's "
            "shape needs a plan of the floor, which there is of the small-size field alone: "
            "docs/where-am-i.md."
        )
        picture = Picture(self._out / "world.png", "The field, the robots at their starts.")
        sections = [Section("", [shown, table, text, picture])]
        write_html(self._out, f"floornav demo: {self._world.description}", sections)


def field_lines(values: dict[str, Any]) -> list[str]:
    """Return what the command says at the end."""
    lines = []
    for name, robot in (values["pose_error_m"] or {}).items():
        known = [(source, e["rms_m"]) for source, e in robot.items() if e["poses"]]
        texts = [f"{source} {rms:.3f} m" for source, rms in known]
        lines.append(f"{name}: pose error (rms) {', '.join(texts) or 'unknown: no pose'}")
    return lines


def _cell(value: float | None) -> str:
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.3g}"
