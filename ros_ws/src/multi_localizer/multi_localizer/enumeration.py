"""The enumeration constraint of the team paper (3.2.2): nobody sees more robots than there are.

The line through two robots cuts the field in two. On neither side can one of them see more robots
(N_OR) than stand there by the robots' own rough poses (N_R); fewer are seen if something is in the
way. A robot without a rough pose may stand on either side.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap


@numba.njit(cache=True)
def num_seen(bearings: np.ndarray, first: int, last: int, base: int) -> tuple[int, int]:
    """Return N_OR: how many of a robot's bearings lie left and right of its bearing `base`."""
    left, right = 0, 0
    for k in range(first, last):
        if k == base:
            continue
        if wrap(bearings[k] - bearings[base]) > 0.0:
            left += 1
        else:
            right += 1
    return left, right


@numba.njit(cache=True)
def num_there(places: np.ndarray, has_place: np.ndarray, a: int, b: int) -> tuple[int, int]:
    """Return N_R: how many robots stand left and right of the line from robot a to robot b."""
    left, right = 0, 0
    along = places[b] - places[a]
    for k in range(len(places)):
        if k in (a, b):
            continue
        beside = along[0] * (places[k, 1] - places[a, 1]) - along[1] * (places[k, 0] - places[a, 0])
        if not has_place[k]:
            left += 1
            right += 1
        elif beside > 0.0:
            left += 1
        else:
            right += 1
    return left, right


@numba.njit(cache=True)
def holds(
    a: int, ray_a: int, b: int, ray_b: int, start: np.ndarray, bearings: np.ndarray,
    places: np.ndarray, has_place: np.ndarray,
) -> bool:  # fmt: skip
    """Return whether robots a and b may see each other along these rays (3.2.3 step 4).

    Args:
        a: One robot.
        ray_a: Its bearing that is taken for b.
        b: The other robot.
        ray_b: Its bearing that is taken for a.
        start: Where each robot's bearings begin, (N + 1,).
        bearings: Of all robots, (M,), rad.
        places: Rough positions, (N, 2), m.
        has_place: Which robots have one, (N,).
    """
    if not (has_place[a] and has_place[b]):
        return True
    left, right = num_there(places, has_place, a, b)
    left_a, right_a = num_seen(bearings, start[a], start[a + 1], ray_a)
    left_b, right_b = num_seen(bearings, start[b], start[b + 1], ray_b)
    return left_a <= left and right_a <= right and left_b <= right and right_b <= left
