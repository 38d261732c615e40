"""The graphs of `evaluate.py faults`: a hall driven by laser, a field driven by camera alone."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from _day_nodes import node_command, write_settings
from floornav_common.se2 import SE2
from sim_bridge.robot_model import RobotModel, load_robot
from sim_bridge.world import World, load_world

_BASICS = ("/clock", "/tf", "/tf_static", "odom", "omni/image_raw")


@dataclass(frozen=True)
class Setup:
    """A graph.

    Attributes:
        name: Of the graph.
        world: Name or file of its world.
        nodes: That run, the simulator left out.
        topics: That go through the relay.
        relays_stereo: Whether images of stereo pairs do so, once asked for.
        frame: Of the goals.
        goals: To go through, in the world, shape (N, 2), m.
        speed: The robot drives from this true speed on, m/s.
        room_m: A fault strikes with so much way left to the goal.
        decel: How hard the robot may brake, m/s^2.
        has_map: Whether a pose on a map is wanted.
        scan_topic: What the planner drives by.
        write: Writes what the nodes are told.
        command: Gives the command that starts a node.
        is_paced: Whether the simulator's time waits for commands.
    """

    name: str
    world: str
    nodes: tuple[str, ...]
    topics: tuple[str, ...]
    frame: str
    goals: np.ndarray
    speed: float
    room_m: float
    decel: float
    has_map: bool
    scan_topic: str
    write: Callable[[Path, World, RobotModel], Path]
    command: Callable[[str, Path], list[str]]
    relays_stereo: bool = False
    is_paced: bool = True

    def load(self) -> tuple[World, RobotModel, SE2]:
        """Return the world, its robot, and where the robot starts."""
        world = load_world(self.world)
        return world, load_robot(world.robots[0]), world.robots[0].pose


def hall() -> Setup:
    """Return the hall: the robot of the demo with goals maps, plans and drives by laser."""
    path = str(Path(__file__).with_name("faults_hall.yaml"))
    goals = load_world(path).goals
    assert goals is not None
    return Setup(
        name="hall", world=path,
        nodes=("grid_mapper", "wavefront_planner", "local_planner", "floor_detector"),
        topics=(*_BASICS, "scan", "sonar"), frame="map", goals=np.array(goals.points_m),
        speed=0.3, room_m=2.4, decel=0.6, has_map=True, scan_topic="scan",
        write=write_settings, command=node_command, relays_stereo=True,
    )  # fmt: skip


def field() -> Setup:
    """Return the field: a small robot whose camera is all that it has to drive by."""
    return Setup(
        name="field", world="small_size_field", nodes=("floor_detector", "local_planner"),
        topics=_BASICS, frame="odom", goals=np.array([[0.25, -0.35], [-1.1, -0.35]]),
        speed=0.2, room_m=0.7, decel=0.3, has_map=False, scan_topic="floor/free_space",
        write=_write_field, command=_field_command,
    )  # fmt: skip


def _write_field(folder: Path, _world: World, _model: RobotModel) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    told: dict[str, dict[str, Any]] = {
        "floor_detector": {"camera_model": "soccer_small_size"},
        "local_planner": {"goal_source": "goal_pose"},
    }
    path = folder / "nodes.yaml"
    nodes = {f"/**/{node}": {"ros__parameters": values} for node, values in told.items()}
    path.write_text(yaml.safe_dump(nodes))
    return path


def _field_command(name: str, settings: Path) -> list[str]:
    modules = {"floor_detector": "floor_perception", "local_planner": "sjmc_planner"}
    words = ["--ros-args", "--params-file", str(settings), "-p", "use_sim_time:=true"]
    if name == "local_planner":
        words += ["-r", "scan:=floor/free_space"]
    return [sys.executable, "-m", f"{modules[name]}.nodes.{name}_node", *words]
