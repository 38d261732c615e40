"""Drives through simulated worlds as a tracker of people sees them, with the truth beside.

The robot roams: it heads for places drawn at random by `omni_velocity`, turns a lot, and looks at
people and furniture from all sides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge import drive as base
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.world import World
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.methods import make_method
from sjmc_planner.planning import BLOCKED, STILL, Goal, Obstacles, RobotState, Velocity

_PERIOD_S = 0.1
_NEW_GOAL_S, _THERE_M = 8.0, 0.5
_ROBOT = RobotConfig(
    drive="differential", radius_m=0.45, margin_m=0.05, speed_m_s=0.8, accel_m_s2=1.0
)


@dataclass(frozen=True)
class Look:
    """One scan.

    Attributes:
        time_s: When.
        scan: What was seen.
        T_base_sensor: From where.
        moved: Where the robot is, seen from where it was at the last look, by odometry.
        truth: Where it is.
        people: x, y, vx, vy of everybody in the world, shape (N, 4).
        names: Who they are.
        is_slipping: Whether odometry says something else than the truth, as when it is held.
    """

    time_s: float
    scan: Scan
    T_base_sensor: SE2
    moved: SE2
    truth: SE2
    people: np.ndarray
    names: tuple[str, ...]
    is_slipping: bool


def roam(world: World, model: str, seconds: float, seed: int) -> Iterator[Look]:
    """Yield the scans of a robot of a model that roams through a world."""
    robot = replace(world.robots[0], model=model, name="")
    simulation = Simulation(replace(world, robots=(robot,)), seed=seed)
    try:
        yield from _Roamer(simulation, seed).looks(seconds)
    finally:
        simulation.close()


class _Roamer:
    def __init__(self, simulation: Simulation, seed: int) -> None:
        self._simulation = simulation
        laser = simulation.models[""].laser_m
        assert laser is not None
        self._T_base_sensor = SE2(*laser, 0.0)
        config = LocalPlannerConfig(robot=_ROBOT, control_period_s=_PERIOD_S)
        self._method = make_method(config)
        self._rng = np.random.default_rng(seed)
        ends = [(w.from_m, w.to_m) for w in simulation.world.walls]
        corners = np.array(ends).reshape(-1, 2)
        self._low, self._high = corners.min(axis=0) + 0.5, corners.max(axis=0) - 0.5
        self._goal, self._goal_from = np.zeros(2), -np.inf

    def looks(self, seconds: float) -> Iterator[Look]:
        """Yield all looks within a time."""
        command, velocity = base.STOP, STILL
        odometry = last = true_last = None
        for _ in range(round(seconds / (STEP_NS * 1e-9))):
            seen = self._simulation.step({"": command})
            robot = seen.robots[""]
            if robot.odometry is not None:
                odometry, v = robot.odometry.pose, robot.odometry.velocity
                velocity = Velocity(v.speed, 0.0, v.yaw_rate)
            if robot.scan is None or odometry is None:
                continue
            truth, people = robot.ground_truth.pose, seen.ground_truth_people
            moved = SE2.identity() if last is None else last.between(odometry)
            true_moved = SE2.identity() if true_last is None else true_last.between(truth)
            off = moved.between(true_moved)
            last, true_last = odometry, truth
            command = self._command(seen.stamp_ns * 1e-9, robot.scan, moved, truth, velocity)
            yield Look(
                seen.stamp_ns * 1e-9, robot.scan, self._T_base_sensor, moved, truth,
                np.array([(p.pose.x, p.pose.y, *p.velocity) for p in people]).reshape(-1, 4),
                tuple(p.name for p in people), off.distance > 0.03 or abs(off.yaw) > 0.02,
            )  # fmt: skip

    def _command(
        self, time_s: float, scan: Scan, moved: SE2, truth: SE2, velocity: Velocity
    ) -> base.Velocity:
        is_there = np.hypot(*(self._goal - (truth.x, truth.y))) < _THERE_M
        if is_there or time_s - self._goal_from > _NEW_GOAL_S:
            self._goal, self._goal_from = self._rng.uniform(self._low, self._high), time_s
        point = (truth.inverse() @ self._goal[None])[0]
        decision = self._method.decide(
            RobotState(velocity, STILL, moved), Obstacles(scan, self._T_base_sensor),
            Goal(point, float(np.hypot(*point))),
        )  # fmt: skip
        if decision.state == BLOCKED:
            self._goal_from = -np.inf
        return base.Velocity(decision.command.x, decision.command.yaw_rate)
