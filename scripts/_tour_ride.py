"""A drive through a world without ROS, by the script that the demo drives with; what it left."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from _tour_drivers import Driver
from sim_bridge.observations import RobotObservation
from sim_bridge.people.people import PersonTruth
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.snapshot import Snapshot
from sim_bridge.world import World


@dataclass
class Ride:
    """A world in the midst of a drive.

    Attributes:
        simulation: It may go on; `close` it.
        last: The last scan, images and pose of each robot.
        omni: The last mirror image of each robot that has such a camera.
        stereo: The last images of each robot's pairs.
        ways: Where each robot was, (N, 2), m.
        people: Where everyone was, by name, (N, 2), m.
        people_now: Everyone who is there now.
    """

    simulation: Simulation
    last: dict[str, Snapshot] = field(default_factory=dict)
    omni: dict[str, np.ndarray] = field(default_factory=dict)
    stereo: dict[str, Any] = field(default_factory=dict)
    ways: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    people: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    people_now: tuple[PersonTruth, ...] = ()

    def take_in(self, name: str, seen: RobotObservation) -> None:
        """Keep what a robot's sensors gave in a step."""
        pose, before = seen.ground_truth.pose, self.last.get(name)
        self.ways.setdefault(name, []).append((pose.x, pose.y))
        if seen.scan is not None or before is None:
            model = self.simulation.models[name]
            self.last[name] = Snapshot(model, pose, seen.scan, ())
        if seen.omni is not None:
            self.omni[name] = seen.omni
        if seen.stereo is not None:
            self.stereo[name] = seen.stereo


def ride(world: World, duration_s: float, seed: int, *, is_driven: bool = True) -> Ride:
    """Return a world after a drive of that length; its robots stand still if not driven."""
    simulation = Simulation(world, seed=seed)
    ridden = Ride(simulation)
    drivers = {name: Driver(world, model) for name, model in simulation.models.items()}
    poses = dict(simulation.starts)
    for _ in range(round(duration_s * 1e9 / STEP_NS)):
        commands = {}
        for name, driver in drivers.items() if is_driven else ():
            last = ridden.last.get(name)
            commands[name] = driver.command(poses[name], None if last is None else last.scan)
        seen = simulation.step(commands)
        for name, robot in seen.robots.items():
            ridden.take_in(name, robot)
            poses[name] = robot.ground_truth.pose
        ridden.people_now = seen.ground_truth_people
        for person in ridden.people_now:
            here = ridden.people.setdefault(person.name, [])
            here.append((person.pose.x, person.pose.y))
    return ridden
