"""How fast SJMC may go towards an obstacle (thesis, 3.6.2 and 4.3.1).

All by one thought: the robot and the obstacle together come no nearer than L_DANGER while the
obstacle makes room. `closing` is v_oy, the obstacle's speed towards the robot: the thesis's axis,
taken by the letter, has the other sign, and an approaching person would make the robot faster.
No bound is below 0 or above what no obstacle allows (inf).
"""

from __future__ import annotations

import math

import numba

_STILL = 1e-6


@numba.njit(cache=True, nogil=True)
def avoid_time(way_out: float, speed_out: float) -> float:
    """Return t_avoid (above eq. 3.4), how long an obstacle takes to leave D; inf if it does not.

    Args:
        way_out: From where it is to the edge that it moves to (dl_avoid), m.
        speed_out: Its speed towards that edge (v_ox), m/s.
    """
    if way_out <= 0.0:
        return 0.0
    return way_out / speed_out if speed_out > _STILL else math.inf


@numba.njit(cache=True, nogil=True)
def aware_time(distance: float, caution: float, aware: float) -> float:
    """Return t_aware, which shrinks as the distance does (asked for in 6.1.1).

    Args:
        distance: To the obstacle, m.
        caution: L_CAUTION, m.
        aware: t_aware at L_CAUTION, s.
    """
    return aware * min(max(distance / caution, 0.0), 1.0)


@numba.njit(cache=True, nogil=True)
def stable_bound(
    distance: float, danger: float, closing: float, t_aware: float, t_avoid: float
) -> float:
    """Return the greatest speed towards who stands in D (eq. 3.5), m/s.

    Args:
        distance: To the obstacle (l_Ro), m.
        danger: L_DANGER, m.
        closing: Speed of the obstacle towards the robot (v_oy), m/s.
        t_aware: Until it notices the robot, s.
        t_avoid: It then takes to leave D, s.
    """
    room = distance - danger
    if math.isinf(t_avoid):
        return max(-closing, 0.0)
    time = t_aware + t_avoid
    if time <= 0.0:
        return math.inf if room > 0.0 else 0.0
    return max((room - closing * t_avoid) / time, 0.0)


@numba.njit(cache=True, nogil=True)
def unstable_bound(distance: float, danger: float, closing: float, t_avoid: float) -> float:
    """Return the greatest speed towards who moves in D (eq. 3.7), m/s; see `stable_bound`."""
    room = distance - danger
    if math.isinf(t_avoid):
        return max(-closing, 0.0)
    if t_avoid <= 0.0:
        return math.inf
    return max(room / t_avoid - closing, 0.0)


@numba.njit(cache=True, nogil=True)
def simple_bound(distance: float, danger: float, response: float) -> float:
    """Return the speed that the thesis ran (eq. 4.5), m/s.

    Args:
        distance: To the nearest thing in the way (l_Ro), m.
        danger: L_DANGER, m.
        response: C = t_aware + t_avoid, s.
    """
    return max((distance - danger) / response, 0.0)
