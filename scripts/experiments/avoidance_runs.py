"""One drive of the avoidance experiment: simulation, perception, method, commands.

The robot knows what a robot knows: images, and odometry for its velocity, its motion and where the
goal is. A command is decided on the image of one cycle before, as the method's node would have it,
and changes within the robot's limits as the node's do. The truth is for the judge alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from experiments.avoidance_fields import Field, world_of
from experiments.avoidance_judge import MOVING, Judge, Run
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge import drive
from sim_bridge.observations import RobotObservation
from sim_bridge.simulation import STEP_NS, Simulation
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.planning import REACHED, STILL, Goal, Method, Obstacles, RobotState, Velocity

PERIOD_S = 0.04  # the paper's mean cycle
LIMIT_S = 60.0
Perception = Callable[[np.ndarray, int], Scan | None]


def drive_field(
    field: Field,
    method: Method,
    robot: RobotConfig,
    see: Perception,
    seed: int,
    omni: dict[str, object],
) -> Run:
    """Drive one field to its end; a touch ends it.

    Args:
        field: Where.
        method: What decides.
        robot: Its limits.
        see: Turns an image (RGB) and its stamp (ns) into free space; None if it cannot.
        seed: Of the simulation.
        omni: Overrides of the camera.
    """
    camera = {"period_s": PERIOD_S, **omni}
    simulation = Simulation(world_of(field, camera), seed=seed)
    try:
        return _Driver(simulation, field, method, robot, see).run()
    finally:
        simulation.close()


class _Driver:
    def __init__(
        self,
        simulation: Simulation,
        field: Field,
        method: Method,
        robot: RobotConfig,
        see: Perception,
    ) -> None:
        self._simulation, self._method, self._robot, self._see = simulation, method, robot, see
        self._judge = Judge(field, [s for s in simulation.solids if s.bottom < 0.2])
        self._velocity, self._command = STILL, STILL
        self._odometry = self._asked_at = SE2.identity()
        self._scan: Scan | None = None
        self._goal = np.array([field.goal])
        self._T_odom_world: SE2 | None = None

    def run(self) -> Run:
        steps_per_cycle = round(PERIOD_S / (STEP_NS * 1e-9))
        is_reached, sent = False, drive.STOP
        for step in range(round(LIMIT_S / (STEP_NS * 1e-9))):
            is_due = step % steps_per_cycle == 0
            seen = self._simulation.step({"": sent} if is_due else {}).robots[""]
            self._take(seen)
            if self._judge.has_touched:
                break
            if seen.omni is None:
                continue
            is_reached = self._decide(seen.omni)
            if is_reached or self._judge.has_given_up:
                break
            sent = drive.Velocity(self._command.x, self._command.yaw_rate, self._command.y)
        return self._judge.result(is_reached)

    def _take(self, seen: RobotObservation) -> None:
        truth = seen.ground_truth
        self._judge.note(
            self._simulation.stamp_ns * 1e-9, truth.pose,
            (truth.velocity.speed, truth.velocity.side_speed), truth.is_touching,
        )  # fmt: skip
        if seen.odometry is None:
            return
        v, self._odometry = seen.odometry.velocity, seen.odometry.pose
        self._velocity = Velocity(v.speed, v.side_speed, v.yaw_rate)
        if self._T_odom_world is None:  # from then on the goal's place is odometry's affair
            self._T_odom_world = self._odometry @ truth.pose.inverse()
            self._goal = self._T_odom_world @ self._goal

    def _decide(self, image: np.ndarray) -> bool:
        """Decide on the image before; tell whether the robot stands at the goal."""
        scan, self._scan = self._scan, self._see(image, self._simulation.stamp_ns)
        if scan is None or self._T_odom_world is None:
            return False
        goal = (self._odometry.inverse() @ self._goal)[0]
        state = RobotState(self._velocity, self._command, self._asked_at.between(self._odometry))
        self._asked_at = self._odometry
        T_now_then = moved_by(self._velocity, PERIOD_S).inverse()
        decision = self._method.decide(
            state, Obstacles(scan, T_now_then), Goal(goal, float(np.hypot(*goal)))
        )
        self._command = ramped(self._command, decision.command, self._robot, PERIOD_S)
        return decision.state == REACHED and self._velocity.speed < MOVING
