"""Backing out of where no course is open, on the way that the robot came.

That way is known to be free: the robot was there. It is remembered as places that move along with
the robot, and backed along in arcs; straight back, what the robot stands close beside is in the
way.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import held_to
from sjmc_planner.planning import TURNING, WAITING, Decision, RobotState, Velocity
from sjmc_planner.sjmc_behind import Behind
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_scene import Scene

_STUCK_S = 1.0  # without a course in all, since it drove last
_FAR_M = 0.2  # so far back is enough to try again
_DRIVES, _STANDS = 0.1, 0.05  # m/s
_STOOD_S = 2.5  # at rest: who stands around it may want the room
_TRAIL_M, _APART_M = 1.5, 0.05  # how long a way is remembered, by places this far apart
_BODY_M = 0.3
_AIM_M = 0.25  # the place on it that it backs to


class Retreat:
    """Knows how far the robot may back, and when it should.

    Args:
        robot: Its limits.
        config: How far it may.
        period: Time between two calls, s.
    """

    def __init__(self, robot: RobotConfig, config: SjmcConfig, period: float) -> None:
        self._robot, self._most, self._period = robot, config.backs_off_m, period
        self._stuck_s, self._left, self._stood_s = 0.0, 0.0, 0.0
        self._trail = np.zeros((1, 2))
        self._came = 0.0
        self._is_shut = False
        self._people = Behind(robot.radius_m + config.backs_off_m + _BODY_M, period)

    def note(self, state: RobotState) -> None:
        """Keep how far it came straight, and the way."""
        came = self._came + state.moved.x - 2.0 * abs(state.moved.yaw) * self._most
        self._came = min(max(came, 0.0), self._most)
        self._left = max(self._left + min(state.moved.x, 0.0), 0.0)
        if abs(state.velocity.x) > _DRIVES:
            self._stuck_s = 0.0
        is_still = abs(state.velocity.x) < _STANDS
        self._stood_s = self._stood_s + self._period if is_still else 0.0
        self._remember(state.moved)

    def mind(self, state: RobotState, scene: Scene) -> None:
        """Back nowhere while somebody may be near behind, whom no beam shows."""
        self._is_shut = self._people.is_near(state, scene)

    @property
    def behind(self) -> float:
        """How far it may back straight on the way that it came, m."""
        return 0.0 if self._is_shut else self._came

    def is_due(self, decision: Decision | None) -> bool:
        """Tell whether to back now; a course that comes and goes is none.

        Args:
            decision: What else there is to do; None = there is no course.
        """
        if self._most == 0.0:
            return False
        if decision is not None and decision.state == WAITING and self._stood_s > _STOOD_S:
            self._stood_s, self._left = 0.0, _FAR_M
        elif decision is None:
            self._stuck_s += self._period
        elif decision.state not in (TURNING, WAITING):
            self._stuck_s = self._left = 0.0
        if self._stuck_s > _STUCK_S:
            self._stuck_s, self._left = 0.0, _FAR_M
        return self._left > 0.0 and len(self._trail) > 1 and not self._is_shut

    @property
    def place(self) -> SE2:
        """A place on the way that it came, in the base frame, at the end of an arc."""
        x, y = self._trail[-min(len(self._trail), round(_AIM_M / _APART_M))]
        return SE2(float(x), float(y), 2.0 * math.atan2(-y, -x))

    def back(self, speed: float) -> Velocity:
        """Return how to back to `place` at a speed, negative, m/s, or as fast as it can."""
        x, y = self.place.x, self.place.y
        bend = 2.0 * y / max(x * x + y * y, _APART_M**2)  # 1/m
        return held_to(Velocity(speed, 0.0, speed * bend), self._robot)

    def end(self) -> None:
        """Back no more: it cannot."""
        self._left = 0.0

    def _remember(self, moved: SE2) -> None:
        """Add the place to the way, or take from it what it backed over."""
        trail = moved.inverse() @ self._trail
        while len(trail) and trail[-1, 0] >= 0.0:
            trail = trail[:-1]
        if not len(trail) or np.hypot(*trail[-1]) >= _APART_M:
            trail = np.vstack((trail, np.zeros((1, 2))))[-round(_TRAIL_M / _APART_M) :]
        self._trail = trail
