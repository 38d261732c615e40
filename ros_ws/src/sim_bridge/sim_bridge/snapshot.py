"""What a robot's range sensors give from a standstill, anywhere in a world."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge.robot_model import RobotModel
from sim_bridge.schema import WorldError
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.world import World


@dataclass(frozen=True)
class Snapshot:
    """One look round.

    Attributes:
        model: The robot.
        T_world_base: Where it truly stands.
        scan: Its last sweep; None without a laser.
        sonar: The last reading of each sonar; () without.
    """

    model: RobotModel
    T_world_base: SE2
    scan: Scan | None
    sonar: tuple[RangeReading, ...]


def snapshot(world: World, pose: SE2, seed: int = 0) -> Snapshot:
    """Return what the world's first robot senses, standing elsewhere than the file says.

    Raises:
        WorldError: The place is inside something, or the world has no robot.
    """
    if not world.robots:
        raise WorldError(f"{world.name} has no robot")
    there = replace(world.robots[0], position_m=(pose.x, pose.y), yaw_deg=math.degrees(pose.yaw))
    simulation = Simulation(replace(world, robots=(there,)), seed=seed)
    try:
        return _look_round(simulation, there.name)
    finally:
        simulation.close()


def stops_of(world: World) -> list[SE2]:
    """Return the start of the first robot and the waypoints of the route, each facing the next."""
    points = [world.robots[0].position_m] if world.robots else []
    points += list(world.route.waypoints_m) if world.route is not None else []
    yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(points, points[1:], strict=False)]
    if world.robots and not yaws:
        return [world.robots[0].pose]
    return [SE2(*p, yaw) for p, yaw in zip(points, [*yaws, *yaws[-1:]], strict=True)]


def _look_round(simulation: Simulation, name: str) -> Snapshot:
    model = simulation.models[name]
    periods = [part.period_s for part in (model.config.laser, model.config.sonar) if part]
    scan: Scan | None = None
    sonar: dict[int, RangeReading] = {}
    pose = simulation.starts[name]
    for _ in range(math.ceil(max(periods, default=0.0) * 1e9 / STEP_NS - 1e-9)):
        seen = simulation.step({}, lambda robot, camera: False).robots[name]
        scan = seen.scan or scan
        for k, reading in enumerate(seen.sonar or ()):
            if k not in sonar or not math.isnan(reading.range):
                sonar[k] = reading
        pose = seen.ground_truth.pose
    return Snapshot(model, pose, scan, tuple(sonar[k] for k in sorted(sonar)))
