"""From a direction to a command that the robot can follow and stop from.

The histogram methods choose a direction and say nothing, or little, of speed. Here the direction
is driven by the laws of `unicycle_motion` (differential) or at once (holonomic), no faster than the
robot can brake from before the goal, and no faster than it can brake from before it touches what
was seen: of a few speeds the fastest is taken after which, a control period later, it could still
stop.
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.beam_ends import BeamEnds
from sjmc_planner.config import RobotConfig
from sjmc_planner.free_way import can_stop
from sjmc_planner.limited_motion import ramped, stopping_speed
from sjmc_planner.planning import STILL, Goal, RobotState, Velocity
from sjmc_planner.unicycle_motion import Unicycle

_AHEAD = 1.0  # beyond the robot it has to have looked this far, m
_SHARES = (1.0, 0.7, 0.5, 0.35, 0.2, 0.1, 0.0)
_NO_SPEED = 1e-3
STANDS = 0.02  # slower than this a robot can turn where it is, m/s


class Steering:
    """Commands of one robot.

    Args:
        robot: What the robot is.
        period: Time between commands, s.
    """

    def __init__(self, robot: RobotConfig, period: float) -> None:
        self._robot, self._period = robot, period
        self._unicycle = Unicycle(robot) if robot.drive == "differential" else None

    def fastest(self, goal: Goal) -> float:
        """Return the travel speed, or what the robot can brake from before the goal, m/s."""
        robot = self._robot
        delay = robot.idle_time_s + self._period
        return min(robot.speed_m_s, stopping_speed(goal.distance, robot.accel_m_s2, delay))

    def heading(self, state: RobotState) -> float:
        """Return the direction that turning starts from, rad; straight ahead if it stands."""
        moving = state.velocity
        if self._unicycle is not None or moving.speed < STANDS:
            return 0.0
        return math.atan2(moving.y, moving.x)

    def turn_radius(self, speed: float) -> float:
        """Return the radius of the narrowest circle at a speed, m."""
        if self._unicycle is not None:
            return speed / self._robot.yaw_rate_rad_s
        return speed * speed / self._robot.accel_m_s2

    def toward(
        self, bearing: float, speed: float, state: RobotState, ends: BeamEnds
    ) -> Velocity | None:
        """Return the command towards a direction; None if the robot can only brake.

        Args:
            bearing: Direction in the base frame, rad.
            speed: Wanted, m/s.
            state: How it moves.
            ends: What the scan shows.
        """
        robot, delay = self._robot, self._robot.idle_time_s + self._period
        horizon = ends.horizon - math.hypot(ends.pose[0], ends.pose[1])
        for share in _SHARES:
            wanted = self._wanted(bearing, share * speed)
            after = ramped(state.velocity, wanted, robot, self._period)
            if after.speed > _NO_SPEED and self._is_blind(after, ends):
                continue
            if can_stop(after, robot, delay, ends.points, horizon):
                return wanted
        return None

    def _is_blind(self, velocity: Velocity, ends: BeamEnds) -> bool:
        """Tell whether no beam looked along the direction of a motion."""
        bearing = math.atan2(velocity.y, velocity.x)
        return bool(ends.unseen(np.array([bearing]), self._robot.radius_m, _AHEAD)[0])

    def _wanted(self, bearing: float, speed: float) -> Velocity:
        if self._unicycle is not None:
            return self._unicycle.command(bearing, speed)
        if speed < _NO_SPEED:
            return STILL
        return Velocity(speed * math.cos(bearing), speed * math.sin(bearing), 0.0)
