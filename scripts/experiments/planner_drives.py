"""One drive of a planning method among people and things: world, method, robot, in lockstep.

The robot knows what a robot knows: its scans, and odometry for its velocity, its motion and where
the goal is. It decides on the newest scan every `period_s`, as the node does, and what it decides
is sent one period later and changes within the robot's limits. The truth is for the judge alone
(`planner_judge`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.planner_judge import Drive, Judge
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge import drive as base
from sim_bridge.observations import Observations
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.world import World
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import ramped
from sjmc_planner.planning import (
    REACHED,
    STILL,
    Decision,
    Goal,
    Method,
    Obstacles,
    RobotState,
    Velocity,
)

_STEP_S = STEP_NS * 1e-9


@dataclass(frozen=True)
class Course:
    """What is driven.

    Attributes:
        world: With one robot.
        goal: Where to, in the world, m.
        limit_s: When it ends at the latest.
        period_s: Time between commands.
        is_over: Tells from the robot's true pose that the drive may end, as having reached the
            goal does; None = only the goal.
        ends_at_contact: Whether the first contact ends it.
    """

    world: World
    goal: tuple[float, float]
    limit_s: float = 60.0
    period_s: float = 0.05
    is_over: Callable[[SE2], bool] | None = None
    ends_at_contact: bool = False


def drive_course(course: Course, method: Method, robot: RobotConfig, seed: int) -> Drive:
    """Drive one course to its end.

    Args:
        course: Where.
        method: What decides; a new one for each drive.
        robot: Its limits.
        seed: Of the simulation.
    """
    simulation = Simulation(course.world, seed=seed)
    try:
        return _Driver(simulation, course, method, robot).run()
    finally:
        simulation.close()


class _Driver:
    """What the robot knows, and the loop."""

    def __init__(
        self, simulation: Simulation, course: Course, method: Method, robot: RobotConfig
    ) -> None:
        self._simulation, self._course = simulation, course
        self._method, self._robot = method, robot
        (self._name, self._model), *others = simulation.models.items()
        if others:
            raise ValueError(f"the world must hold one robot, got {len(others) + 1}")
        laser = self._model.laser_m
        if laser is None:
            raise ValueError("the robot must have a laser")
        self._T_base_laser = SE2(*laser, 0.0)
        self._velocity, self._command = STILL, STILL
        self._odometry: SE2 | None = None
        self._asked_at = SE2.identity()
        self._goal = np.array([course.goal])
        self._scan: tuple[Scan, SE2] | None = None
        self._judge = Judge(simulation, self._model, course.goal)

    def run(self) -> Drive:
        """Drive until it is there, it is over, or time is up."""
        course = self._course
        steps_per_cycle = round(course.period_s / _STEP_S)
        sent, is_there = base.STOP, False
        for step in range(round(course.limit_s / _STEP_S)):
            is_due = step % steps_per_cycle == 0
            if is_due:
                sent, is_there = self._cycle()
            seen = self._simulation.step({self._name: sent} if is_due else {})
            self._take(seen)
            self._judge.note(seen, self._name)
            pose = seen.robots[self._name].ground_truth.pose
            is_over = course.is_over is not None and course.is_over(pose)
            if is_there or is_over:
                return self._judge.result(is_reached=True)
            if course.ends_at_contact and self._judge.contacts:
                break
        return self._judge.result(is_reached=False)

    def _take(self, observations: Observations) -> None:
        """Take odometry and the scan; the goal's place is odometry's affair from the first on."""
        seen = observations.robots[self._name]
        if seen.odometry is not None:
            v, pose = seen.odometry.velocity, seen.odometry.pose
            self._velocity = Velocity(v.speed, v.side_speed, v.yaw_rate)
            if self._odometry is None:
                T_odom_world = pose @ seen.ground_truth.pose.inverse()
                self._goal, self._asked_at = T_odom_world @ self._goal, pose
            self._odometry = pose
        if seen.scan is not None and self._odometry is not None:
            self._scan = seen.scan, self._odometry

    def _cycle(self) -> tuple[base.Velocity, bool]:
        """Return what was decided a period ago, to be sent now, and whether the robot is there."""
        now = self._command
        if self._scan is None or self._odometry is None:
            return base.STOP, False
        scan, taken_at = self._scan
        to_goal = (self._odometry.inverse() @ self._goal)[0]
        moved = self._asked_at.between(self._odometry)
        self._asked_at = self._odometry
        decision = self._method.decide(
            RobotState(self._velocity, now, moved),
            Obstacles(scan, self._odometry.between(taken_at) @ self._T_base_laser),
            Goal(to_goal, float(np.hypot(*to_goal))),
        )
        self._judge.decided(self._simulation.stamp_ns * 1e-9, decision)
        self._command = ramped(now, decision.command, self._robot, self._course.period_s)
        is_there = _is_there(decision, self._velocity)
        return base.Velocity(now.x, now.yaw_rate, now.y), is_there


def _is_there(decision: Decision, velocity: Velocity) -> bool:
    return decision.state == REACHED and velocity.speed < 0.05
