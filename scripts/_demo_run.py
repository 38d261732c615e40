"""One run of the demo: its processes, what was heard meanwhile, and what became of it."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from _demo_domain import refuse_other_clock
from _demo_glass import glass_recall
from _demo_pictures import write_first_images, write_overview, write_pictures
from _demo_report import figures, in_world, write_report, write_tum
from _demo_surface import visible_surface
from _demo_watch import DemoWatch, Heard, Liveness
from _live_view import start_live_view
from _processes import ChildDiedError, Processes
from _saying import saying
from _watched import watched
from floornav_common.reporting import Progress, say
from floornav_common.transform3 import Transform3
from sim_bridge.laser import beam_angles
from sim_bridge.robot_model import load_robot
from sim_bridge.simulation import Simulation
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import World

_SCRIPTS = Path(__file__).resolve().parent
_RECORDED = (
    "/scan", "/odom", "/tf", "/tf_static", "/pose", "/map", "/cmd_vel", "/robot_description",
    "/ground_truth/odom", "/ground_truth/contact", "/sonar", "/map/glass",
)  # fmt: skip
_START_TIMEOUT_S = 180.0
_LONGEST_S = 300.0


class Demo:
    """One run: its processes, what was heard, and what became of it.

    Args:
        world: The world, with a route and one robot.
        args: The command line.
        out: The result folder.
        has_window: True shows pybullet's window.
    """

    def __init__(self, world: World, args: argparse.Namespace, out: Path, has_window: bool) -> None:
        assert world.route is not None
        self.problem = "stopped before the end"
        self._world, self._args, self._out, self._has_window = world, args, out, has_window
        self._route = world.route
        self._start = world.robots[0].pose
        self._heard = Heard()
        self._wall_s = 0.0

    def run(self) -> None:
        """Start everything, watch until the end of the route, stop everything."""
        try:
            with watched(DemoWatch, self._out / "logs") as (watch, children, spin):
                self._heard = watch.heard
                self._drive(children, watch, spin)
            self.problem = self._touch()
        except ChildDiedError as error:
            self.problem = str(error)

    def results(self) -> dict[str, Any]:
        """Return this run's keys of the summary."""
        surfaces = [s for s in solids_of(self._world) if s.is_at_height(self._laser_height())]
        found = figures(self._heard, self._start, surfaces, self._visible(surfaces), self._wall_s)
        bag = self._out / "bag"
        is_there = bag.is_dir() and any(bag.iterdir())
        return {
            **found,
            "scans": self._num_scans(),
            "glass_recall": self._glass_recall(surfaces),
            "touched": self._heard.has_touched,
            "bag": "bag" if is_there else None,
            **({"problem": self.problem} if self.problem else {}),
        }

    def write(self, values: dict[str, Any]) -> None:
        """Write trajectories, pictures and the page."""
        write_tum(self._out / "trajectory.tum", in_world(self._heard.estimate, self._start))
        write_tum(self._out / "ground_truth.tum", self._heard.truth)
        solids = solids_of(self._world)
        write_pictures(self._out, self._heard, self._start, solids, self._laser_height())
        simulation = Simulation(self._world, seed=self._args.seed)
        write_overview(self._out / "world.png", simulation.overview())
        images = write_first_images(self._out, simulation)
        simulation.close()
        title = f"floornav demo: {self._world.description or self._world.name}"
        has_glass = any(solid.glass is not None for solid in solids)
        write_report(self._out, title, values, self.problem, images, has_glass=has_glass)

    def _drive(self, children: Processes, watch: DemoWatch, spin: Callable[[], None]) -> None:
        # The simulator comes last, and its time begins when all others listen.
        is_quiet = self._args.quiet
        text = "starting the nodes (the first time, grid_mapper compiles its kernels) ..."
        say(text, is_quiet=is_quiet)
        for name, command in self._commands().items():
            if name != "sim_bridge":
                children.start(name, command)
        for name, doing in (
            ("grid_mapper", "compiling its kernels"),
            ("route_follower", "starting"),
        ):
            with saying(f"waiting for {name}: {doing} ...", is_quiet=is_quiet):
                children.wait_for_line(name, "ready", _START_TIMEOUT_S, spin)
        if self._args.live:
            start_live_view(children, self._out / "logs", load_robot(self._world.robots[0]), spin)
        refuse_other_clock(watch, 0)
        children.start("sim_bridge", self._commands()["sim_bridge"])
        with saying("waiting for sim_bridge: loading the world ...", is_quiet=is_quiet):
            children.wait_for_line("sim_bridge", "ready", _START_TIMEOUT_S, spin)
        self._watch(children, watch, spin)
        say("stopping the nodes ...", is_quiet=is_quiet)
        end_ns = self._heard.truth[-1][0] if self._heard.truth else 0
        children.stop("route_follower")
        # The last map and the last scans are still under way.
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            spin()
        self._heard.cut_off(end_ns)

    def _watch(self, children: Processes, watch: DemoWatch, spin: Callable[[], None]) -> None:
        started = time.monotonic()
        heard, total = self._heard, self._args.duration
        time_moves, poses_come = Liveness("simulated time"), Liveness("grid_mapper's pose")
        with Progress("demo", 100.0, is_quiet=self._args.quiet) as bar:
            while children.exit_code("route_follower") is None:
                spin()
                now = time.monotonic()
                self._wall_s = now - started
                children.check(may_end=("route_follower",))
                refuse_other_clock(watch, 1)
                time_moves.look(now, heard.sim_s)
                poses_come.look(now, len(heard.estimate))
                bar.update(min(self._percent(), 99.0), _note(heard))
                if heard.has_touched or heard.sim_s >= (total or _LONGEST_S):
                    break
            is_through = children.exit_code("route_follower") == 0
            percent = 100.0 if is_through else self._percent()
            bar.update(percent, _note(heard), is_last=True)
        children.check(may_end=("route_follower",))
        if total is None and heard.sim_s >= _LONGEST_S:
            raise ChildDiedError(f"the route was not driven in {_LONGEST_S:.0f} simulated seconds")

    def _num_scans(self) -> int:
        # Counted from time: a busy machine may lose a message on the way to this process.
        laser = load_robot(self._world.robots[0]).config.laser
        return 0 if laser is None else int(self._heard.sim_s / laser.period_s + 1e-6)

    def _touch(self) -> str:
        if not self._heard.has_touched:
            return ""
        at = self._heard.touched_at
        where = f" at ({at.x:.2f}, {at.y:.2f})" if at is not None else ""
        return f"the robot touched something{where}"

    def _percent(self) -> float:
        points = np.array(self._route.waypoints_m)
        length = float(np.hypot(*np.diff(points, axis=0).T).sum())
        share = self._heard.path / length
        if self._args.duration is not None:
            share = max(share, self._heard.sim_s / self._args.duration)
        return 100.0 * min(share, 1.0)

    def _visible(self, surfaces: list[Solid]) -> np.ndarray:
        """Return points of the surfaces that the laser could see on its true way."""
        model = load_robot(self._world.robots[0])
        laser = model.config.laser
        assert laser is not None
        mount = Transform3(model.mounts[laser.frame]).to_se2()
        poses = [pose @ mount for _, pose in self._heard.truth]
        return visible_surface(surfaces, poses, beam_angles(laser), laser.range_max_m)

    def _glass_recall(self, surfaces: list[Solid]) -> float | None:
        way = np.array([(pose.x, pose.y) for _, pose in self._heard.truth]).reshape(-1, 2)
        return glass_recall(self._heard.grid, self._start, surfaces, way)

    def _laser_height(self) -> float:
        model = load_robot(self._world.robots[0])
        assert model.config.laser is not None
        return float(model.mounts[model.config.laser.frame][2, 3])

    def _commands(self) -> dict[str, list[str]]:
        route = self._start.inverse() @ np.array(self._route.waypoints_m)
        numbers = ", ".join(f"{value:.4f}" for value in route.ravel())
        record = [sys.executable, str(_SCRIPTS / "record.py"), *_RECORDED]
        return {
            "record": [*record, "--out", str(self._out / "bag")],
            "grid_mapper": _node("grid_mapper.nodes.grid_mapper_node", use_sim_time="true"),
            "route_follower": _node(
                "sim_bridge.nodes.route_follower_node",
                use_sim_time="true",
                route_m=f"[{numbers}]",
                speed_m_s=str(self._route.speed_m_s),
            ),
            "sim_bridge": _node(
                "sim_bridge.nodes.sim_bridge_node",
                world=str(self._args.world),
                seed=str(self._args.seed),
                real_time_factor=str(float(self._args.rtf)),
                view=str(self._has_window).lower(),
                start_nodes="[grid_mapper, route_follower, bag_recorder, demo_watch]",
                pace_nodes="[grid_mapper, route_follower]",
                pace_lag_s="0.12",
            ),
        }


def _node(module: str, **parameters: str) -> list[str]:
    given = [word for key, value in parameters.items() for word in ("-p", f"{key}:={value}")]
    return [sys.executable, "-m", module, "--ros-args", *given]


def _note(heard: Any) -> str:
    return (
        f"{heard.sim_s:5.1f} s simulated, {heard.path:5.1f} m driven, "
        f"{len(heard.estimate)} scans mapped"
    )
