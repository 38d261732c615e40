"""A demo in a world with goals: the whole graph drives them, then the usual robot does, offline."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from _day_figures import day_figures, surroundings
from _day_film import Stage, write_film
from _day_load import LoadMeter
from _day_nodes import (
    BUILDING,
    STEREO_NODES,
    node_command,
    node_names,
    record_command,
    simulator_command,
    write_settings,
)
from _day_report import write_day
from _day_robot import USUAL, pilot_of
from _day_watch import DayWatch
from _demo_domain import refuse_other_clock
from _demo_watch import Liveness
from _live_view import start_live_view
from _processes import ChildDiedError, Processes
from _saying import saying
from _watched import watched
from experiments.goal_drives import GOAL_LIMIT_S, GoalDrive, drive_goals
from experiments.stereo_world_map import map_of_world
from floornav_common.reporting import Progress, say
from multi_localizer.voxel_map import save_voxel_map
from sim_bridge.robot_model import load_robot
from sim_bridge.world import World

_START_TIMEOUT_S = 240.0
_LOOK_S = 1.0
_LAST_S = 1.0  # the last map and the last scans are still under way
_VOXEL_CELL_M = 0.02


class Day:
    """One run: its processes, what was heard, the usual robot's run, and what became of both.

    Args:
        world: With goals and one robot that has a laser.
        args: The command line.
        out: The result folder.
        has_window: True shows pybullet's window.
    """

    def __init__(self, world: World, args: argparse.Namespace, out: Path, has_window: bool) -> None:
        assert world.goals is not None
        self.problem = "stopped before the end"
        self._world, self._args, self._out, self._has_window = world, args, out, has_window
        self._model = load_robot(world.robots[0])
        self._start = world.robots[0].pose
        self._goals = self._start.inverse() @ np.array(world.goals.points_m)
        self._names = node_names(self._model)
        self._watch: DayWatch | None = None
        self._loads = LoadMeter()
        self._usual: GoalDrive | None = None
        self._wall_s = 0.0

    def run(self) -> None:
        """Start everything, send the goals, stop everything, and run the usual robot."""
        make_watch = lambda: DayWatch(self._model, self._goals, GOAL_LIMIT_S)  # noqa: E731
        try:
            with watched(make_watch, self._out / "logs") as (self._watch, children, spin):
                self._begin(children, self._watch, spin)
                self._follow(children, self._watch, spin)
                say("stopping the nodes ...", is_quiet=self._args.quiet)
            self._run_usual()
            self.problem = ""
        except ChildDiedError as error:
            self.problem = str(error)

    def results(self) -> dict[str, Any]:
        """Return this run's keys of the summary; a touch is a problem too."""
        assert self._watch is not None
        bag = self._out / "bag"
        found = day_figures(
            self._world, self._model, self._watch, self._usual, self._loads, self._wall_s, bag
        )
        if found["collisions"] and not self.problem:
            places = ", ".join(f"{t['what']} at {t['time_s']:.1f} s" for t in found["touched"])
            self.problem = f"the robot touched {places}"
        return {
            **found,
            "bag": "bag" if bag.is_dir() and any(bag.iterdir()) else None,
            **({"problem": self.problem} if self.problem else {}),
        }

    def write(self, values: dict[str, Any]) -> None:
        """Write pictures and the page."""
        assert self._watch is not None
        heard = self._watch.heard
        write_day(
            self._out, self._world, self._model, self._watch, self._usual, values, self.problem
        )
        if self._args.film and heard.record.truth:
            around = surroundings(self._world, self._model)
            places = self._start @ self._goals
            stage = Stage(around.solids, places, self._start, around.outline, around.torso_radius)
            write_film(self._out / "film.gif", heard.record, heard.maps, stage)

    def _begin(self, children: Processes, watch: DayWatch, spin: Callable[[], None]) -> None:
        # The simulator comes last, and its time begins when all others listen.
        is_quiet = self._args.quiet
        settings = write_settings(self._out / "nodes", self._world, self._model)
        say(
            f"starting {len(self._names) + 2} processes: {', '.join(self._names)}, record and "
            "sim_bridge (the first time, they compile their kernels) ...", is_quiet=is_quiet,
        )  # fmt: skip
        bag = self._out / "bag"
        images = bool(self._args.images)
        children.start("record", record_command(bag, with_images=images, model=self._model))
        for name in self._names:
            if name == STEREO_NODES[-1]:
                self._make_voxel_map(settings.parent / "voxel_map.npz")
            children.start(name, node_command(name, settings))
        for name in self._names:
            with saying(f"waiting for {name} ...", is_quiet=True):
                children.wait_for_line(name, "ready", _START_TIMEOUT_S, spin)
        if self._args.live:
            start_live_view(children, self._out / "logs", self._model, spin)
        refuse_other_clock(watch, 0)
        simulator = simulator_command(self._args, self._names, self._has_window)
        children.start("sim_bridge", simulator)
        with saying("waiting for sim_bridge: loading the world ...", is_quiet=is_quiet):
            children.wait_for_line("sim_bridge", "ready", _START_TIMEOUT_S, spin)

    def _make_voxel_map(self, path: Path) -> None:
        text = "making the voxel map for stereo_localizer from the world, as if surveyed before ..."
        with saying(text, is_quiet=self._args.quiet):
            made = map_of_world(str(self._args.world), cell=_VOXEL_CELL_M)
            save_voxel_map(path, replace(made, frame=BUILDING))

    def _follow(self, children: Processes, watch: DayWatch, spin: Callable[[], None]) -> None:
        started = looked = time.monotonic()
        record, total = watch.heard.record, self._args.duration
        time_moves = Liveness("simulated time")
        with Progress("demo", 100.0, is_quiet=self._args.quiet) as bar:
            while not watch.is_done and record.sim_s < (total or np.inf):
                spin()
                now = time.monotonic()
                if now - looked > _LOOK_S:
                    self._loads.look({**children.pids, "demo_watch": os.getpid()})
                    looked = now
                if not record.sim_s:
                    started = now  # time waits until all have found each other
                self._wall_s = now - started
                children.check()
                refuse_other_clock(watch, 1)
                time_moves.look(now, record.sim_s)
                bar.update(min(_percent(watch, total), 99.0), _note(watch))
            bar.update(_percent(watch, total), _note(watch), is_last=True)
        end = time.monotonic() + _LAST_S
        while time.monotonic() < end:
            spin()

    def _run_usual(self) -> None:
        say("the same seed and goals, as most robots drive today: laser-only map, VFH+ ...",
            is_quiet=self._args.quiet)  # fmt: skip
        pilot = pilot_of(self._world, self._model, USUAL)
        total = self._args.duration or GOAL_LIMIT_S * len(self._goals)
        with Progress("usual", total, is_quiet=self._args.quiet) as bar:
            self._usual = drive_goals(
                self._world, pilot, self._args.seed, self._args.duration,
                lambda time_s: bar.update(min(time_s, total), f"{time_s:5.1f} s simulated"),
            )  # fmt: skip
            bar.update(total, f"{self._usual.record.sim_s:5.1f} s simulated", is_last=True)


def _percent(watch: DayWatch, total: float | None) -> float:
    share = max(watch.goals.number, 0) / max(watch.heard.record.num_goals, 1)
    if total is not None:
        share = max(share, watch.heard.record.sim_s / total)
    return 100.0 * min(share, 1.0)


def _note(watch: DayWatch) -> str:
    record = watch.heard.record
    state = record.states[-1][1] if record.states else "starting"
    goal = min(watch.goals.number + 1, record.num_goals)
    return f"{record.sim_s:5.1f} s simulated, goal {goal} of {record.num_goals}, {state}"
