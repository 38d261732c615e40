"""The fourth stage of VFH+: openings between blocked sectors, candidate directions, their cost.

Ulrich and Borenstein 1998. A narrow opening gives its middle; a wide one both sides
at half of s_max from its borders, and the goal's direction if that lies between them.
"""

from __future__ import annotations

import math

import numba
import numpy as np

_TURN = 2.0 * math.pi
_SAME = 1e-9  # costs nearer than this are equal, and the first one counts


@numba.njit(cache=True, nogil=True)
def openings(is_blocked):  # type: ignore[no-untyped-def]
    """Return the runs of open sectors as (right border, left border), both open, shape (K, 2).

    The left border is not below the right one, so it may be `num` or more for a run over sector 0.
    One entry (0, num - 1) stands for an open circle.

    Args:
        is_blocked: Shape (num,), bool.
    """
    num = len(is_blocked)
    found = np.empty((num // 2 + 1, 2), dtype=np.int64)
    first = 0
    while first < num and not is_blocked[first]:
        first += 1
    if first == num:
        found[0, 0], found[0, 1] = 0, num - 1
        return found[:1]
    count = 0
    right = -1
    for k in range(first + 1, first + num + 1):
        if is_blocked[k % num]:
            if right >= 0:
                found[count, 0], found[count, 1] = right, k - 1
                if right >= num:
                    found[count] -= num
                count += 1
            right = -1
        elif right < 0:
            right = k
    return found[:count]


@numba.njit(cache=True, nogil=True)
def candidates(is_blocked, goal, wide):  # type: ignore[no-untyped-def]
    """Return the directions worth weighing, shape (C,), in (-pi, pi].

    Args:
        is_blocked: The masked histogram, shape (num,), bool.
        goal: Bearing of the goal, rad.
        wide: Openings of more sectors than this are wide (s_max).
    """
    num = len(is_blocked)
    alpha = _TURN / num
    runs = openings(is_blocked)
    found = np.empty(3 * len(runs))
    count = 0
    for right, left in runs:
        sector = right + (goal / alpha - right) % num
        if left - right == num - 1:  # all is open
            found[0] = goal / alpha
            return found[:1] * alpha
        if left - right < wide:
            found[count] = 0.5 * (right + left)
            count += 1
            continue
        found[count], found[count + 1] = right + 0.5 * wide, left - 0.5 * wide
        count += 2
        if right + 0.5 * wide <= sector <= left - 0.5 * wide:
            found[count] = sector
            count += 1
    bearings = found[:count] * alpha
    return bearings - _TURN * np.ceil(bearings / _TURN - 0.5)


@numba.njit(cache=True, nogil=True)
def cheapest(bearings, goal, heading, before, weights):  # type: ignore[no-untyped-def]
    """Return the index of the candidate with the least cost.

    Args:
        bearings: The candidates, shape (C,), rad.
        goal: Bearing of the goal (k_t), rad.
        heading: Direction the robot moves in (theta_i), rad.
        before: Direction that was chosen last (k_n,i-1), rad.
        weights: mu_1, mu_2, mu_3 of the angles to these.
    """
    best, least = -1, np.inf
    for i in range(len(bearings)):
        cost = weights[0] * _off(bearings[i], goal)
        cost += weights[1] * _off(bearings[i], heading)
        cost += weights[2] * _off(bearings[i], before)
        if cost < least - _SAME:
            best, least = i, cost
    return best


@numba.njit(cache=True, nogil=True, inline="always")
def _off(a, b):  # type: ignore[no-untyped-def]
    """Return the angle between two bearings, in [0, pi]."""
    return abs((a - b) - _TURN * np.rint((a - b) / _TURN))
