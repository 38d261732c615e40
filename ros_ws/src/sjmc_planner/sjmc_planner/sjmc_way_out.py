"""Ways out for a robot that has no course: back along the way that it came, or turn the free way.

A box with a long tail that stands beside a wall can turn its nose past it where its tail would not
pass. Commanded a course, it turns by the shorter way round; where that is shut, it may have to
take the longer one, and then has to keep to it.
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.planning import BACKING, TURNING, Decision, Velocity
from sjmc_planner.sjmc_moment import Moment, MomentReader
from sjmc_planner.sjmc_retreat import Retreat
from sjmc_planner.sjmc_rollout import Foresight
from sjmc_planner.unicycle_motion import Unicycle

_STEP = 0.1  # between two headings that are looked at, rad
_FACES = 0.2  # so near to the course a turn is done, rad
_NOBODY = np.zeros((0, 5))
_QUARTER, _ROUND = 0.5 * math.pi, 2.0 * math.pi
_HALF = np.array([1.0, 1.0, 0.5])  # of what is kept off things: where it was, and on the spot
_STANDS, _DRIFTS = 0.03, 0.1  # m/s
_BACK = -0.15  # m/s


class WayOut:
    """Backs and turns a differential robot on the spot.

    Args:
        unicycle: Its limits; None for a holonomic one, which needs neither.
        foresight: Looks ahead.
        moments: Tells what is clear.
        period: Time between two decisions, s.
    """

    def __init__(
        self, unicycle: Unicycle | None, foresight: Foresight, moments: MomentReader, period: float
    ) -> None:
        self._unicycle, self._foresight, self._moments = unicycle, foresight, moments
        self._period = period
        self._left = 0.0  # of a turn, rad

    def note(self, turned: float) -> None:
        """Take what the robot turned since the last call, rad."""
        self._left = self._left - turned if abs(self._left) > _FACES else 0.0

    def begin_turn(self, moment: Moment, bearings: np.ndarray) -> Decision | None:
        """Turn to the first open course that it can turn to; None if there is none.

        Args:
            moment: What is known.
            bearings: Of open courses, shape (K,), rad.
        """
        if self._unicycle is None or moment.state.velocity.speed > _STANDS:
            return None
        bearings, near = bearings[np.abs(bearings) > _FACES], moment.near * _HALF
        if not len(bearings) or self._is_free(float(bearings[0]), moment):
            return None  # what keeps it from turning there is none of the things
        free = self.free_turn(1.0, near), self.free_turn(-1.0, near)
        for bearing in bearings:
            turns = bearing % _ROUND, -bearing % _ROUND  # to the left, to the right
            sides = [k for k in (0, 1) if turns[k] <= free[k]]
            if sides:
                side = min(sides, key=lambda k: turns[k])
                self._left = float(-turns[1] if side else turns[0])
                break
        return self.turn(moment)

    def turn(self, moment: Moment) -> Decision | None:
        """Return how a turn goes on; None if there is none, or something came into its way."""
        # No more than a quarter at a time, or the robot would turn the shorter way.
        bearing = math.copysign(min(abs(self._left), _QUARTER), self._left)
        if self._unicycle is None or abs(bearing) <= _FACES:
            return None
        now, around = moment.state.velocity, (moment.near * _HALF, moment.people)
        seen = self._foresight.look(now, bearing, 0.0, self._period, *around)
        if now.speed > _DRIFTS or not self._moments.is_clear(seen, moment):
            self._left = 0.0
            return None
        command = Velocity(0.0, 0.0, self._unicycle.command(bearing, 0.0).yaw_rate)
        return Decision(command, TURNING, "on the spot")

    def _is_free(self, bearing: float, moment: Moment) -> bool:
        return self.free_turn(math.copysign(1.0, bearing), moment.near) >= abs(bearing)

    def free_turn(self, side: float, near: np.ndarray) -> float:
        """Return how far it can turn to a side, 1 or -1, before it meets something, rad."""
        for turn in np.arange(_STEP, _ROUND + _STEP, _STEP):
            seen = self._foresight.gaps(near, _NOBODY, (0.0, 0.0, side * turn))
            if seen.thing_gap < 0.0:
                return float(turn - _STEP)
        return _ROUND

    def back(self, moment: Moment, retreat: Retreat) -> Decision | None:
        """Return how to back out of where it is stuck; None where that is not safe."""
        command, place = retreat.back(_BACK), retreat.place
        around = moment.near * _HALF, moment.scene.people
        seen = self._foresight.obey(moment.state.velocity, command, self._period, *around)
        there = self._foresight.gaps(*around, (place.x, place.y, place.yaw))
        is_clear = self._moments.is_clear(seen, moment) and self._moments.is_clear(there, moment)
        if self._unicycle is None or not is_clear:
            retreat.end()
            return None
        self._left = 0.0
        return Decision(command, BACKING, "no course is open")
