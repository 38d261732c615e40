"""What comes of a command: the robot under its limits, among things that stand and people who walk.

The robot goes on as it is for its idle time, does what is commanded for `hold`, then brakes; people
go on at the velocity they have. Gaps are from the robot's box, or its circle if it has no box.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import Velocity
from sjmc_planner.sjmc_region import Box
from sjmc_planner.unicycle_motion import _ahead, _changed, _step

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
_DT = 0.1
_HERE = (0.0, 0.0, 0.0)
_NO_GAP = 1e-6
_BEYOND = 0.6  # farther than this from where it may come nothing counts, m


@dataclass(frozen=True)
class Foreseen:
    """What comes of a command.

    Attributes:
        thing_gap: Least distance to a thing, m, beyond what is to be kept of it; 0 or less in it.
        people_gap: Least distance to a person's disk, m; negative in it.
        people_time: When that is, s.
    """

    thing_gap: float
    people_gap: float
    people_time: float


class Foresight:
    """Looks ahead for one robot.

    Args:
        robot: What the robot is.
        box: What it takes up.
        delay: How long it goes on as it is, s.
        until: How far ahead to look, s.
    """

    def __init__(self, robot: RobotConfig, box: Box, delay: float, until: float) -> None:
        self._limits = (robot.accel_m_s2, robot.yaw_rate_rad_s, robot.yaw_accel_rad_s2)
        is_box = robot.half_width_m > 0.0 and robot.drive == "differential"
        self._box = (box.front, box.rear, box.half_width) if is_box else (0.0, 0.0, 0.0)
        self._air = 0.0 if is_box else robot.radius_m
        self._times = (delay, until)
        self._size = robot.radius_m
        self._is_omni = robot.drive == "omni"

    def look(
        self, now: Velocity, course: float, speed: float, hold: float, things: np.ndarray,
        people: np.ndarray,
    ) -> Foreseen:  # fmt: skip
        """Return what comes of driving on a course for a while, then braking.

        Args:
            now: How the robot moves.
            course: Bearing to drive along, rad.
            speed: How fast, m/s.
            hold: For how long, s.
            things: What stands, shape (M, 2), m, or as `kept_off` returns it, shape (M, 3).
            people: Rows x, y, vx, vy, radius, shape (N, 5).
        """
        return self._look(now, course, speed, math.nan, hold, things, people)

    def obey(
        self, now: Velocity, command: Velocity, hold: float, things: np.ndarray,
        people: np.ndarray,
    ) -> Foreseen:  # fmt: skip
        """Return what comes of a command as it is sent, such as an arc back; else as `look`."""
        if self._is_omni:
            course = math.atan2(command.y, command.x)
            return self.look(now, course, command.speed, hold, things, people)
        return self._look(now, 0.0, command.x, command.yaw_rate, hold, things, people)

    def _look(
        self, now: Velocity, course: float, speed: float, yaw_rate: float, hold: float,
        things: np.ndarray, people: np.ndarray,
    ) -> Foreseen:  # fmt: skip
        """Return what comes of it; a yaw rate that is not NaN is driven in place of the course."""
        delay, until = self._times
        state = (0.0, 0.0, 0.0, now.x, now.y if self._is_omni else now.yaw_rate)
        found = _foresee(
            state, self._is_omni, course, speed, yaw_rate, hold, self._limits, delay, until,
            self._box, things, people,
        )  # fmt: skip
        return Foreseen(found[0] - self._air, found[1] - self._air, found[2])

    def gaps(
        self, things: np.ndarray, people: np.ndarray, at: tuple[float, float, float] = _HERE
    ) -> Foreseen:
        """Return the distances of now, or if the robot were at x, y, yaw."""
        here = (*at, 0.0, 0.0)
        found = _gaps(here, self._box, 0.0, things, people, np.inf, np.inf, 0.0)
        return Foreseen(found[0] - self._air, found[1] - self._air, found[2])

    def kept_off(self, things: np.ndarray, margin: float) -> np.ndarray:
        """Return things and the distance to keep of each: rows x, y, m, shape (M, 3).

        That is the margin; where the robot stands nearer than that to one, what there is, so that
        it may go on along what it stands beside. But never less than half of the margin, except
        for those that are nearer already, which must not come any nearer. So what is taken for
        something in the robot itself, which nothing can be, takes no care off the rest.
        """
        gaps = _each_gap(things, self._box) - self._air
        near = max(min(margin, gaps.min(initial=np.inf) - _NO_GAP), 0.5 * margin)
        return np.column_stack((things[:, :2], np.minimum(gaps - _NO_GAP, near)))

    def within_reach(
        self, now: Velocity, fastest: float, things: np.ndarray, hold: float = 0.0
    ) -> np.ndarray:
        """Return the things that braking after driving for `hold` may come near, (K, 2)."""
        reach = self._reach(now, fastest, hold)
        is_near = things[:, 0] ** 2 + things[:, 1] ** 2 < reach * reach
        return things[is_near]

    def may_meet(
        self, now: Velocity, fastest: float, people: np.ndarray, hold: float = 0.0
    ) -> np.ndarray:
        """Return the people who may come near meanwhile and until the end of the look, (K, 5)."""
        walk = np.sqrt(people[:, 2] ** 2 + people[:, 3] ** 2) * self._times[1]
        far = np.sqrt(people[:, 0] ** 2 + people[:, 1] ** 2)
        return people[far < self._reach(now, fastest, hold) + walk + people[:, 4]]

    def _reach(self, now: Velocity, fastest: float, hold: float) -> float:
        speed = max(now.speed, fastest)
        stop = speed * (self._times[0] + _DT + hold + speed / (2.0 * self._limits[0]))
        return self._size + stop + _BEYOND


@numba.njit(cache=True, nogil=True)
def _foresee(  # type: ignore[no-untyped-def]
    state, is_omni, course, speed, yaw_rate, hold, limits, delay, until, box, things, people
):
    least_thing, least_person, at = np.inf, np.inf, 0.0
    least_thing, least_person, at = _gaps(
        state, box, 0.0, things, people, least_thing, least_person, at
    )
    t = delay
    state = _drifted(state, is_omni, delay)
    while True:
        is_still = abs(state[3]) < 1e-3 and abs(state[4]) < 1e-3
        if not (is_still and t > delay + hold):
            least_thing, least_person, at = _gaps(
                state, box, t, things, people, least_thing, least_person, at
            )
        else:
            least_thing, least_person, at = _gaps(
                state, box, t, things[:0], people, least_thing, least_person, at
            )
        if t >= until:
            break
        is_braking = t > delay + hold - 1e-9
        if is_omni:
            state = _omni_step(state, course, 0.0 if is_braking else speed, limits[0], _DT)
        elif not (is_braking or math.isnan(yaw_rate)):
            state = _changed(state, speed, yaw_rate, limits, _DT)
        else:
            state = _step(state, math.nan if is_braking else course, speed, limits, _DT)
        t += _DT
    return least_thing, least_person, at


@numba.njit(cache=True, nogil=True, inline="always")
def _drifted(state, is_omni, t):  # type: ignore[no-untyped-def]
    if is_omni:
        return state[0] + state[3] * t, state[1] + state[4] * t, state[2], state[3], state[4]
    return _ahead(state, t)


@numba.njit(cache=True, nogil=True)
def _omni_step(state, course, speed, accel, dt):  # type: ignore[no-untyped-def]
    x, y, yaw, vx, vy = state
    dx, dy = speed * math.cos(course) - vx, speed * math.sin(course) - vy
    length = math.hypot(dx, dy)
    share = min(1.0, accel * dt / max(length, 1e-12))
    vx2, vy2 = vx + share * dx, vy + share * dy
    return x + 0.5 * (vx + vx2) * dt, y + 0.5 * (vy + vy2) * dt, yaw, vx2, vy2


@numba.njit(cache=True, nogil=True)
def _gaps(state, box, t, things, people, least_thing, least_person, at):  # type: ignore[no-untyped-def]
    c, s = math.cos(state[2]), math.sin(state[2])
    for i in range(len(things)):
        keep = things[i, 2] if things.shape[1] > 2 else 0.0
        gap2 = _gap2(things[i, 0] - state[0], things[i, 1] - state[1], c, s, box)
        least = least_thing + keep
        if least > 0.0 and gap2 < least * least:
            least_thing = math.sqrt(gap2) - keep
    for i in range(len(people)):
        x = people[i, 0] + t * people[i, 2] - state[0]
        y = people[i, 1] + t * people[i, 3] - state[1]
        gap = _signed_gap(x, y, c, s, box) - people[i, 4]
        if gap < least_person:
            least_person, at = gap, t
    return least_thing, least_person, at


@numba.njit(cache=True, nogil=True)
def _each_gap(things, box):  # type: ignore[no-untyped-def]
    """Return how far each thing is from the box, shape (M,), m."""
    gaps = np.empty(len(things))
    for i in range(len(things)):
        gaps[i] = math.sqrt(_gap2(things[i, 0], things[i, 1], 1.0, 0.0, box))
    return gaps


@numba.njit(cache=True, nogil=True, inline="always")
def _gap2(dx, dy, c, s, box):  # type: ignore[no-untyped-def]
    """Return the squared distance of a point from the box; 0 in it."""
    x, y = c * dx + s * dy, c * dy - s * dx
    ahead = max(x - box[0], -box[1] - x, 0.0)
    aside = max(abs(y) - box[2], 0.0)
    return ahead * ahead + aside * aside


@numba.njit(cache=True, nogil=True, inline="always")
def _signed_gap(dx, dy, c, s, box):  # type: ignore[no-untyped-def]
    """Return the distance of a point from the box; in it, how deep, negative."""
    x, y = c * dx + s * dy, c * dy - s * dx
    ahead, aside = max(x - box[0], -box[1] - x), abs(y) - box[2]
    if ahead < 0.0 and aside < 0.0:
        return max(ahead, aside)
    return math.hypot(max(ahead, 0.0), max(aside, 0.0))
