"""A demo run through a world that is not mapped: its robots are driven, its sensors pictured."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from _demo_domain import refuse_other_clock
from _demo_pictures import write_overview
from _processes import ChildDiedError, Processes
from _saying import saying
from _tour_drivers import Driver
from _tour_report import changed_people_model, write_images, write_page, write_plan
from _tour_ride import ride
from _tour_watch import TourWatch
from _watched import watched
from floornav_common.reporting import Progress, say
from sim_bridge.robot_model import load_robot
from sim_bridge.solids import solids_of
from sim_bridge.world import World
from sim_bridge.world_picture import without_cameras

DEFAULT_S = 20.0
_PICTURE_S = 6.0
_SCRIPTS = Path(__file__).resolve().parent
_START_TIMEOUT_S = 180.0
_STALL_S = 60.0


class Tour:
    """One run: sim_bridge and the recorder as processes, this one drives and hears.

    Args:
        world: The world.
        args: The command line.
        out: The result folder.
        has_window: True shows pybullet's window.
    """

    def __init__(self, world: World, args: argparse.Namespace, out: Path, has_window: bool) -> None:
        self.problem = "stopped before the end"
        self._world, self._args, self._out, self._has_window = world, args, out, has_window
        self._models = {placed.name: load_robot(placed) for placed in world.robots}
        self._drivers = {name: Driver(world, model) for name, model in self._models.items()}
        self._heard: TourWatch | None = None
        self._wall_s = 0.0

    def run(self) -> None:
        """Start everything, drive, stop everything."""
        make_watch = lambda: TourWatch(self._models, self._drivers)  # noqa: E731
        try:
            with watched(make_watch, self._out / "logs") as (self._heard, children, spin):
                self._start(children, spin)
                self._watch(children, self._heard, spin)
                say("stopping the nodes ...", is_quiet=self._args.quiet)
            self.problem = ""
        except ChildDiedError as error:
            self.problem = str(error)

    def results(self) -> dict[str, Any]:
        """Return this run's keys of the summary."""
        assert self._heard is not None
        sim_s, bag = self._heard.sim_s, self._out / "bag"
        robots = {}
        for name, heard in self._heard.robots.items():
            way = np.array([(pose.x, pose.y) for _, pose in heard.truth]).reshape(-1, 2)
            robots[name] = {
                "model": self._models[name].config.urdf.removesuffix(".urdf"),
                "path_m": float(np.hypot(*np.diff(way, axis=0).T).sum()),
                "touched": heard.has_touched,
                "messages": dict(heard.counts),
            }
        return {
            "sim_s": round(sim_s, 3),
            "rtf": sim_s / self._wall_s if self._wall_s else None,
            "robots": robots,
            "people": max((len(people) for _, people in self._heard.people), default=0),
            "people_model": changed_people_model(self._world),
            "bag": "bag" if bag.is_dir() and any(bag.iterdir()) else None,
            **({"problem": self.problem} if self.problem else {}),
        }

    def write(self, values: dict[str, Any]) -> None:
        """Write pictures and the page."""
        assert self._heard is not None
        write_plan(self._out / "plan.png", self._world, self._models, self._heard)
        self._write_world()
        images = write_images(self._out, self._heard.robots)
        title = f"floornav demo: {self._world.description or self._world.name}"
        has_glass = any(solid.glass is not None for solid in solids_of(self._world))
        write_page(self._out, title, values, self.problem, images, has_glass=has_glass)

    def _write_world(self) -> None:
        """Draw the world in the midst of such a drive (driven again, without ROS and cameras)."""
        ridden = ride(without_cameras(self._world), _PICTURE_S, self._args.seed)
        try:
            write_overview(self._out / "world.png", ridden.simulation.overview())
        finally:
            ridden.simulation.close()

    def _start(self, children: Processes, spin: Callable[[], None]) -> None:
        say("starting the nodes ...", is_quiet=self._args.quiet)
        for name, command in self._commands().items():
            children.start(name, command)
        text = "waiting for sim_bridge: loading the world ..."
        with saying(text, is_quiet=self._args.quiet):
            children.wait_for_line("sim_bridge", "ready", _START_TIMEOUT_S, spin)

    def _watch(self, children: Processes, watch: TourWatch, spin: Callable[[], None]) -> None:
        total = self._args.duration or DEFAULT_S
        started = moved = time.monotonic()
        last_s = 0.0
        with Progress("demo", 100.0, is_quiet=self._args.quiet) as bar:
            while watch.sim_s < total:
                spin()
                children.check()
                refuse_other_clock(watch, 1)
                now = time.monotonic()
                if watch.sim_s > last_s:
                    last_s, moved = watch.sim_s, now
                elif now - moved > _STALL_S:
                    raise ChildDiedError(f"time stood still for {_STALL_S:.0f} s; see logs/")
                self._wall_s = now - started
                share = min(watch.sim_s / total, 0.99)
                bar.update(100.0 * share, f"{watch.sim_s:5.1f} s simulated")
            bar.update(100.0, f"{watch.sim_s:5.1f} s simulated", is_last=True)

    def _commands(self) -> dict[str, list[str]]:
        given = {
            "world": str(self._args.world),
            "world_parameters": "[" + ", ".join(self._args.set) + "]",
            "seed": str(self._args.seed),
            "real_time_factor": str(float(self._args.rtf)),
            "view": str(self._has_window).lower(),
            "start_nodes": "[bag_recorder, demo_watch]",
            "pace_nodes": "[demo_watch]",
        }
        if not self._args.set:
            del given["world_parameters"]
        words = [word for key, value in given.items() for word in ("-p", f"{key}:={value}")]
        simulator = [sys.executable, "-m", "sim_bridge.nodes.sim_bridge_node", "--ros-args", *words]
        record = [sys.executable, str(_SCRIPTS / "record.py"), *self._topics()]
        return {
            "record": [*record, "--out", str(self._out / "bag")],
            "sim_bridge": simulator,
        }

    def _topics(self) -> list[str]:
        topics = ["/tf", "/tf_static"]
        for name, model in self._models.items():
            below = f"/{name}" if name else ""
            names = ["odom", "cmd_vel", "ground_truth/odom", "robot_description"]
            names += ["scan"] if model.config.laser else []
            names += ["sonar"] if model.config.sonar else []
            topics += [f"{below}/{topic}" for topic in names]
        has_people = self._world.people or self._world.crowd or self._world.recorded_people
        return [*topics, *(["/ground_truth/people"] if has_people else [])]
