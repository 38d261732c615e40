"""One run of the avoidance experiment: simulation, perception, method, and what is measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.avoidance_fields import ROBOT_RADIUS, Field, world_of
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge import drive
from sim_bridge.observations import RobotObservation
from sim_bridge.simulation import STEP_NS, Simulation
from sjmc_planner.planning import REACHED, STILL, Goal, Method, Obstacles, RobotState, Velocity

PERIOD_S = 0.04  # the paper's mean cycle
LIMIT_S = 60.0
TURN_RAD = math.radians(5.0)
TRACK_S = 1.0 / 3.0
_MOVING = 0.05
_GIVE_UP_S, _NEARER_M = 10.0, 0.05  # without coming nearer to the goal than ever before
Perception = Callable[[np.ndarray, int], Scan | None]


@dataclass(frozen=True)
class Run:
    """What came of it.

    Attributes:
        field: Where.
        is_reached: Whether the robot came to stand at the goal.
        has_collided: Whether it touched anything.
        time_s: Until it stood there, or until it gave up.
        path_m: Way driven.
        min_clearance_m: Least distance between the robot and anything.
        turn_start_s: When its velocity was first 5 degrees off the goal; None if never.
        track: Poses x, y every 1/3 s, shape (N, 2).
        path: The same every cycle, shape (M, 2).
    """

    field: Field
    is_reached: bool
    has_collided: bool
    time_s: float
    path_m: float
    min_clearance_m: float
    turn_start_s: float | None
    track: np.ndarray
    path: np.ndarray


def drive_field(
    field: Field,
    method: Method,
    see: Perception,
    seed: int,
    omni: dict[str, object],
) -> Run:
    """Drive one field to its end; a touch ends it.

    Args:
        field: Where.
        method: What decides.
        see: Turns an image (RGB) and its stamp (ns) into free space; None if it cannot.
        seed: Of the simulation.
        omni: Overrides of the camera.
    """
    camera = {"period_s": PERIOD_S, **omni}
    simulation = Simulation(world_of(field, camera), seed=seed)
    try:
        return _Driver(simulation, field, method, see).run()
    finally:
        simulation.close()


class _Driver:
    def __init__(
        self, simulation: Simulation, field: Field, method: Method, see: Perception
    ) -> None:
        self._simulation, self._field, self._method, self._see = simulation, field, method, see
        self._solids = [s for s in simulation.solids if s.bottom < 0.2]
        self._velocity, self._command = STILL, STILL
        self._odometry = self._asked_at = SE2.identity()
        self._path: list[tuple[float, float]] = [field.start]
        self._clearance, self._turn_start = math.inf, None
        self._nearest, self._nearer_at = math.inf, 0.0

    def run(self) -> Run:
        steps_per_cycle = round(PERIOD_S / (STEP_NS * 1e-9))
        is_reached = has_collided = False
        sent = drive.STOP
        for step in range(round(LIMIT_S / (STEP_NS * 1e-9))):
            is_due = step % steps_per_cycle == 0
            seen = self._simulation.step({"": sent} if is_due else {}).robots[""]
            self._measure(seen)
            if seen.ground_truth.is_touching or self._clearance <= 0.0:
                has_collided = True
                break
            if seen.omni is None:
                continue
            is_reached = self._decide(seen)
            if is_reached or self._time_s - self._nearer_at > _GIVE_UP_S:
                break
            sent = drive.Velocity(self._command.x, self._command.yaw_rate, self._command.y)
        return self._result(is_reached, has_collided)

    @property
    def _time_s(self) -> float:
        return self._simulation.stamp_ns * 1e-9

    def _decide(self, seen: RobotObservation) -> bool:
        pose = seen.ground_truth.pose
        scan = self._see(seen.omni, self._simulation.stamp_ns)
        if scan is None:
            return False
        goal = (pose.inverse() @ np.array([self._field.goal]))[0]
        state = RobotState(self._velocity, self._command, self._asked_at.between(self._odometry))
        self._asked_at = self._odometry
        decision = self._method.decide(
            state, Obstacles(scan, SE2.identity()), Goal(goal, float(np.hypot(*goal)))
        )
        self._command = decision.command
        return decision.state == REACHED and self._velocity.speed < _MOVING

    def _measure(self, seen: RobotObservation) -> None:
        pose, velocity = seen.ground_truth.pose, seen.ground_truth.velocity
        if seen.odometry is not None:
            v, self._odometry = seen.odometry.velocity, seen.odometry.pose
            self._velocity = Velocity(v.speed, v.side_speed, v.yaw_rate)
        here = np.array([[pose.x, pose.y]])
        near = min(float(s.signed_distance(here)[0]) for s in self._solids) - ROBOT_RADIUS
        self._clearance = min(self._clearance, near)
        self._path.append((pose.x, pose.y))
        x, y = self._field.goal[0] - pose.x, self._field.goal[1] - pose.y
        if math.hypot(x, y) < self._nearest - _NEARER_M:
            self._nearest, self._nearer_at = math.hypot(x, y), self._time_s
        if math.hypot(velocity.speed, velocity.side_speed) < _MOVING:
            return
        bearing = math.atan2(velocity.side_speed, velocity.speed) + pose.yaw
        off = math.remainder(bearing - math.atan2(y, x), 2.0 * math.pi)
        if self._turn_start is None and abs(off) > TURN_RAD:
            self._turn_start = self._time_s

    def _result(self, is_reached: bool, has_collided: bool) -> Run:
        path = np.array(self._path)
        every = round(TRACK_S / (STEP_NS * 1e-9))
        return Run(
            field=self._field, is_reached=is_reached, has_collided=has_collided,
            time_s=self._time_s, path_m=float(np.hypot(*np.diff(path, axis=0).T).sum()),
            min_clearance_m=self._clearance, turn_start_s=self._turn_start,
            track=path[::every], path=path,
        )  # fmt: skip
