"""How long predicted ways are free: eq. 13 to 15 for all directions at once, compiled.

The table of grown obstacles (`growth`) has its entries at the bearings 2 pi k / N. A way is free
until the first step at which its distance from where it began is not below the table's entry at
its bearing (eq. 15); what lies behind an obstacle counts as obstacle.
"""

from __future__ import annotations

import numba
import numpy as np

_START2 = 1e-12  # where the robot stands has no bearing, and is never closed, m^2


@numba.njit(cache=True, nogil=True, inline="always")
def _bearing(y, x):  # type: ignore[no-untyped-def]
    """Return atan2(y, x) to 1.2e-5 rad, for less (Abramowitz and Stegun 1964, 4.4.47)."""
    ax, ay = abs(x), abs(y)
    z = min(ax, ay) / max(ax, ay, 1e-300)
    z2 = z * z
    a = ((((0.0208351 * z2 - 0.0851330) * z2 + 0.1801410) * z2 - 0.3302995) * z2 + 0.9998660) * z
    a = 0.5 * np.pi - a if ay > ax else a
    a = np.pi - a if x < 0.0 else a
    return -a if y < 0.0 else a


@numba.njit(cache=True, nogil=True, inline="always")
def _is_inside(x, y, nearest2, table):  # type: ignore[no-untyped-def]
    r2 = x * x + y * y  # eq. 13
    if r2 < max(nearest2, _START2):
        return True
    num = len(table)
    entry = int(np.rint(_bearing(y, x) * (num / (2.0 * np.pi)))) % num  # eq. 14
    return r2 < table[entry] * table[entry]


@numba.njit(cache=True, nogil=True)
def free_times(va, vb, accel, idle_time, dt, until, table):  # type: ignore[no-untyped-def]
    """Return T_j of eq. 15 for ways under an acceleration limit (eq. 12).

    Args:
        va: Velocity now, shape (2,), m/s.
        vb: Velocities commanded, shape (J, 2), m/s.
        accel: Limit of the acceleration, m/s^2.
        idle_time: Time until a command acts, s.
        dt: Step, s.
        until: How far to look, s.
        table: Distances to grown obstacles, shape (N,), m.

    Returns:
        Shape (J,), s; inf where nothing is hit until then.
    """
    times = np.full(len(vb), np.inf)
    nearest2 = np.min(table) ** 2
    num_steps = int(np.ceil(until / dt - 1e-9))
    for j in range(len(vb)):
        dx, dy = vb[j, 0] - va[0], vb[j, 1] - va[1]
        length = np.hypot(dx, dy)
        ta, per_length = length / accel, 1.0 / max(length, 1e-12)
        for i in range(num_steps + 1):
            t = min(i * dt, until)
            if t < ta:
                bend = 0.5 * accel * t * t * per_length
                x = va[0] * (t + idle_time) + bend * dx
                y = va[1] * (t + idle_time) + bend * dy
            else:
                bend = 0.5 * length / accel
                x = va[0] * idle_time + vb[j, 0] * t - bend * dx
                y = va[1] * idle_time + vb[j, 1] * t - bend * dy
            if not _is_inside(x, y, nearest2, table):
                times[j] = t
                break
    return times


@numba.njit(cache=True, nogil=True)
def straight_free_times(bearings, speed, table):  # type: ignore[no-untyped-def]
    """Return T_j of a robot that is taken to move along each bearing at once, shape (J,), s."""
    times = np.empty(len(bearings))
    num = len(table)
    for j in range(len(bearings)):
        entry = int(np.rint(bearings[j] * (num / (2.0 * np.pi)))) % num
        times[j] = table[entry] / speed
    return times


@numba.njit(cache=True, nogil=True)
def can_stop(x, y, vx, vy, accel, idle_time, table):  # type: ignore[no-untyped-def]
    """Tell whether a robot at (x, y) that brakes straight stays inside the table on its way.

    Args:
        x: Where it is, m.
        y: Where it is, m.
        vx: How it moves, m/s.
        vy: How it moves, m/s.
        accel: Braking, m/s^2.
        idle_time: Time until it brakes, s.
        table: Distances to grown obstacles and to the end of what is known, shape (N,), m.
    """
    speed = np.hypot(vx, vy)
    if speed < 1e-6:
        return True
    length = speed * idle_time + 0.5 * speed * speed / accel
    num = int(np.ceil(length / 0.01)) + 1
    for i in range(num + 1):
        along = length * i / num / speed
        if not _is_inside(x + along * vx, y + along * vy, 0.0, table):
            return False
    return True


@numba.njit(cache=True, nogil=True)
def first_stoppable(order, va, vb, accel, idle_time, t, table):  # type: ignore[no-untyped-def]
    """Return the first direction from which, a time later, the robot can still stop; -1 if none.

    Args:
        order: Indices into `vb` in the order to try, shape (J,).
        va: Velocity now, shape (2,), m/s.
        vb: Velocities commanded, shape (J, 2), m/s.
        accel: Limit of acceleration and braking, m/s^2.
        idle_time: Time until a command acts, s.
        t: How long the command is in force before the next one, s.
        table: As for `can_stop`.
    """
    for j in order:
        dx, dy = vb[j, 0] - va[0], vb[j, 1] - va[1]
        length = np.hypot(dx, dy)
        rising = min(t, length / accel)
        share = accel * rising / max(length, 1e-12)  # of dv reached: eq. 10
        vx, vy = va[0] + share * dx, va[1] + share * dy
        bend = share * (t - 0.5 * rising)  # eq. 12 once more: the integral of eq. 10
        x, y = va[0] * (t + idle_time) + bend * dx, va[1] * (t + idle_time) + bend * dy
        if can_stop(x, y, vx, vy, accel, idle_time, table):
            return j
    return -1
