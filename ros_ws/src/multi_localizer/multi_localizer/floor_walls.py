"""Walls of a plan as compiled code wants them, and which one a bearing meets first."""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.floor_plan import FloorPlan

NUM_SEEN = 9
"""Columns of walls from a place: gap, normal (2), tangent (2), way along from its corner, length,
which wall, 1 / gap."""
_EDGE_M = 1e-9


def walls_of(plan: FloorPlan) -> np.ndarray:
    """Return corner, tangent, outward normal, c and length of each edge, (W, 8)."""
    return np.column_stack((plan.corners, plan.tangents, plan.normals, plan.offsets, plan.lengths))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def walls_from(walls, x, y, seen):  # type: ignore[no-untyped-def]
    """Fill in the walls whose inner side faces a place; return how many there are.

    Args:
        walls: Of `walls_of`, (W, 8).
        x: Of the place, m.
        y: The same.
        seen: (W, 9).
    """
    num = 0
    for w in range(len(walls)):
        gap = walls[w, 6] - walls[w, 4] * x - walls[w, 5] * y
        if gap <= 0.0:
            continue
        seen[num, 0] = gap
        seen[num, 1], seen[num, 2] = walls[w, 4], walls[w, 5]
        seen[num, 3], seen[num, 4] = walls[w, 2], walls[w, 3]
        seen[num, 5] = (x - walls[w, 0]) * walls[w, 2] + (y - walls[w, 1]) * walls[w, 3]
        seen[num, 6] = walls[w, 7]
        seen[num, 7], seen[num, 8] = w, 1.0 / gap
        num += 1
    return num


@numba.njit(cache=True, error_model="numpy", nogil=True)
def wall_ahead(seen, num, ex, ey):  # type: ignore[no-untyped-def]
    """Return which of the walls a bearing meets first, -1 if none, and 1 over how far away.

    Args:
        seen: Of `walls_from`, (W, 9).
        num: How many of its rows count.
        ex: The bearing's unit vector in the map.
        ey: The same.
    """
    nearest, found = 0.0, -1
    for k in range(num):
        facing = seen[k, 1] * ex + seen[k, 2] * ey
        if facing <= nearest * seen[k, 0]:
            continue
        along = seen[k, 5] * facing + seen[k, 0] * (seen[k, 3] * ex + seen[k, 4] * ey)
        if -_EDGE_M * facing <= along <= (seen[k, 6] + _EDGE_M) * facing:
            nearest, found = facing * seen[k, 8], k
    return found, nearest
