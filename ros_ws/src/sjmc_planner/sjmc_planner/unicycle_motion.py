"""Ways of a differential robot towards a direction, under its limits of acceleration and turning.

A holonomic robot commanded a velocity v_b gets there by eq. 10; a differential one has to turn
first. What stands for eq. 10 here is the law that it is then driven by: turn towards the direction
as fast as the limits allow without passing it, w = sign(e) sqrt(2 a_w |e|) for the angle e that is
left, and drive v_c cos(e) meanwhile, or turn on the spot beyond 90 degrees. Speed and yaw rate
change no faster than the limits, so the way is predicted by the same steps that will be driven.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.free_times import _is_inside
from sjmc_planner.planning import Velocity

# numba keeps these kernels by this file's date alone: one that changes `_is_inside` has to change
# this file too, or a kernel with the old one goes on being used.
_SOFTNESS = 0.7  # of the square-root law: the turn is no harder than the limit even when late
_DT = 0.05


@numba.njit(cache=True, nogil=True)
def _wanted(off, speed, yaw_rate, yaw_accel):  # type: ignore[no-untyped-def]
    """Return the speed and the yaw rate wanted with an angle left to turn."""
    turn = math.sqrt(2.0 * _SOFTNESS * yaw_accel * abs(off))
    w = math.copysign(min(turn, yaw_rate, 4.0 * abs(off)), off)
    return speed * max(math.cos(off), 0.0), w


@numba.njit(cache=True, nogil=True)
def _step(state, bearing, speed, limits, dt):  # type: ignore[no-untyped-def]
    """Return (x, y, yaw, v, w) a step later; `bearing` is NaN for braking."""
    wanted_v, wanted_w = 0.0, 0.0
    if not math.isnan(bearing):
        off = (bearing - state[2] + math.pi) % (2.0 * math.pi) - math.pi
        wanted_v, wanted_w = _wanted(off, speed, limits[1], limits[2])
    return _changed(state, wanted_v, wanted_w, limits, dt)


@numba.njit(cache=True, nogil=True)
def _changed(state, wanted_v, wanted_w, limits, dt):  # type: ignore[no-untyped-def]
    """Return (x, y, yaw, v, w) a step later, on the way to a speed and a yaw rate."""
    x, y, yaw, v, w = state
    accel, _, yaw_accel = limits
    v2 = v + min(max(wanted_v - v, -accel * dt), accel * dt)
    w2 = w + min(max(wanted_w - w, -yaw_accel * dt), yaw_accel * dt)
    along, middle = 0.5 * (v + v2) * dt, yaw + 0.25 * (w + w2) * dt
    x, y = x + along * math.cos(middle), y + along * math.sin(middle)
    return x, y, yaw + 0.5 * (w + w2) * dt, v2, w2


@numba.njit(cache=True, nogil=True)
def _idled(v, w, t):  # type: ignore[no-untyped-def]
    """Return (x, y, yaw, v, w) after going on as it is."""
    yaw = w * t
    return v * t * math.cos(0.5 * yaw), v * t * math.sin(0.5 * yaw), yaw, v, w


@numba.njit(cache=True, nogil=True)
def _free_times(v, w, bearings, speed, limits, idle, dt, until, table):  # type: ignore[no-untyped-def]
    times = np.full(len(bearings), np.inf)
    nearest2 = np.min(table) ** 2
    num_steps = int(np.ceil(until / dt - 1e-9))
    for j in range(len(bearings)):
        state = _idled(v, w, idle)
        for i in range(num_steps + 1):
            if not _is_inside(state[0], state[1], nearest2, table):
                times[j] = i * dt
                break
            state = _step(state, bearings[j], speed, limits, dt)
    return times


@numba.njit(cache=True, nogil=True)
def _first_stoppable(order, v, w, bearings, speed, limits, idle, t, table):  # type: ignore[no-untyped-def]
    for j in order:
        state = _step(_idled(v, w, idle), bearings[j], speed, limits, t)
        state = _ahead(state, idle)
        is_free = _is_inside(state[0], state[1], 0.0, table)
        while is_free and state[3] > 1e-3:
            state = _step(state, math.nan, 0.0, limits, _DT)
            is_free = _is_inside(state[0], state[1], 0.0, table)
        if is_free or state[3] <= 1e-3:
            return j
    return -1


@numba.njit(cache=True, nogil=True)
def _ahead(state, t):  # type: ignore[no-untyped-def]
    x, y, yaw, v, w = state
    middle = yaw + 0.5 * w * t
    return x + v * t * math.cos(middle), y + v * t * math.sin(middle), yaw + w * t, v, w


class Unicycle:
    """The limits of one robot, applied.

    Args:
        robot: What the robot is.
    """

    def __init__(self, robot: RobotConfig) -> None:
        self._limits = (robot.accel_m_s2, robot.yaw_rate_rad_s, robot.yaw_accel_rad_s2)
        self._idle_time = robot.idle_time_s

    def command(self, bearing: float, speed: float) -> Velocity:
        """Return what to command to go towards a bearing in the base frame."""
        v, w = _wanted(bearing, speed, *self._limits[1:])
        return Velocity(float(v), 0.0, float(w))

    def free_times(
        self, now: Velocity, bearings: np.ndarray, speed: float, dt: float, until: float,
        table: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Return T_j of each bearing, as `free_times.free_times`."""
        args = now.x, now.yaw_rate, bearings, speed, self._limits, self._idle_time
        return np.asarray(_free_times(*args, dt, until, table))

    def first_stoppable(
        self, order: np.ndarray, now: Velocity, bearings: np.ndarray, speed: float, t: float,
        table: np.ndarray,
    ) -> int:  # fmt: skip
        """Return the first bearing after which, a time later, braking stays inside; -1 if none."""
        args = now.x, now.yaw_rate, bearings, speed, self._limits, self._idle_time
        return int(_first_stoppable(order, *args, t, table))

    def ways(
        self, now: Velocity, bearings: np.ndarray, speed: float, t: np.ndarray
    ) -> list[np.ndarray]:
        """Return the way towards each bearing at evenly spaced times, shapes (K, 2), m."""
        found = []
        for bearing in bearings:
            state = _idled(now.x, now.yaw_rate, self._idle_time)
            points = [state[:2]]
            for dt in np.diff(t):
                state = _step(state, bearing, speed, self._limits, dt)
                points.append(state[:2])
            found.append(np.array(points))
        return found
