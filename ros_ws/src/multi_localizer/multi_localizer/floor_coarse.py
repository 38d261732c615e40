"""Poses near starts by weights that fall with the residual, and which of them are different.

A share of the border is enough to find out where it fits; all of it is fitted in `floor_polish`.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from multi_localizer.floor_kernels import residual
from multi_localizer.floor_walls import NUM_SEEN, wall_ahead, walls_from

BEHIND = 5.0  # how much farther off a piece behind its wall still counts
BEHIND_COST = 3.0  # of a piece behind its wall, 1 for one that is hidden
FALL = 0.6  # of the residual that halves a weight, with every step
FINE_PX = 4.0  # the same once the pose is nearly there; until then few pieces do
SPREAD_PX = 1.0  # the same in the end
FEW = 3  # every third piece
STEPS = 20
HOPING = 3  # steps after which the cost is taken seriously
NEVER = 0.5  # what fits less of the border than this share of what the best does is no rival
STILL = 1e-4  # m, rad: steps shorter than this together are the last
SAME = 0.1, 0.1  # m, rad: fits so near each other are one
_CUT = 5.0  # deviations beyond which nothing weighs


@numba.njit(cache=True, error_model="numpy", nogil=True)
def anneal(values, step, found, walls, first_px, last_px, least):  # type: ignore[no-untyped-def]
    """Move a pose by weights that fall with the residual, less and less gently.

    Args:
        values: Of `BorderRays`, as much of it as is to count.
        step: Every so many of them do.
        found: x, y, yaw, the border's offset, and the cost: 0 all border fits, 1 all is hidden;
            floor behind walls costs more. Gets the new ones, (5,).
        walls: Of `walls_of`, (W, 8).
        first_px: Residual that halves a weight in the beginning.
        last_px: The same in the end.
        least: Of the cost: what fits less than this after some steps is left as it is.
    """
    seen, both = np.empty((len(walls), NUM_SEEN)), np.empty((4, 5))
    scale, num_last = first_px / FALL, 0
    for _ in range(STEPS):
        scale = max(last_px, FALL * scale)
        num_last += scale == last_px
        found[4] = _weigh(values, step, found, walls, seen, scale, both)
        d = solved(both)
        found[:3] += d[:3]
        found[3] = d[3]
        is_still = abs(d[0]) + abs(d[1]) + abs(d[2]) < STILL
        if num_last and (is_still or last_px > SPREAD_PX):
            break
        if num_last > HOPING and found[4] > least:
            break


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _weigh(values, step, found, walls, seen, scale, both):  # type: ignore[no-untyped-def]
    """Add up H and b, upper half, of the weighted pieces into (4, 5); return the cost."""
    c, s, offset = np.cos(found[2]), np.sin(found[2]), found[3]
    num = walls_from(walls, found[0], found[1], seen)
    both[:] = 0.0
    cost, total = 0.0, 0.0
    for i in range(0, len(values), step):
        share = values[i, 6]
        total += share
        ex = c * values[i, 0] - s * values[i, 1]
        ey = s * values[i, 0] + c * values[i, 1]
        k, near = wall_ahead(seen, num, ex, ey)
        if k < 0:
            cost += share
            continue
        z, by_x, by_y, by_yaw = residual(values[i], seen[k], near, ex, ey)
        off = z - offset
        part = off * off / (SPREAD_PX * SPREAD_PX + off * off)
        cost += share * (part * BEHIND_COST if off < -SPREAD_PX else part)
        # Little shows floor behind a wall, but much hides a wall.
        ratio = off / (BEHIND * scale if z < offset and scale > SPREAD_PX else scale)
        ratio *= ratio
        if ratio < _CUT * _CUT:
            _add(both, share / (1.0 + ratio) ** 2, by_x, by_y, by_yaw, z)
    return cost / total


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _add(both, w, by_x, by_y, by_yaw, z):  # type: ignore[no-untyped-def]
    """Add a piece to H and b of x, y, yaw and the offset, upper half."""
    x, y, yaw = w * by_x, w * by_y, w * by_yaw
    both[0, 0] += x * by_x
    both[0, 1] += x * by_y
    both[0, 2] += x * by_yaw
    both[0, 3] -= x
    both[0, 4] -= x * z
    both[1, 1] += y * by_y
    both[1, 2] += y * by_yaw
    both[1, 3] -= y
    both[1, 4] -= y * z
    both[2, 2] += yaw * by_yaw
    both[2, 3] -= yaw
    both[2, 4] -= yaw * z
    both[3, 3] += w
    both[3, 4] += w * z


@numba.njit(cache=True, error_model="numpy", nogil=True)
def solved(both):  # type: ignore[no-untyped-def]
    """Return d of H d = b, an offset of deviation 1 px thought likely (Cholesky, in place).

    Args:
        both: H, upper half, with b as its last column, (N, N + 1).
    """
    num = len(both)
    both[3, 3] += 1.0
    d = np.empty(num)
    for j in range(num):
        pivot = both[j, j] * (1.0 + 1e-6) + 1e-9
        for i in range(j):
            pivot -= both[i, j] * both[i, j]
        pivot = np.sqrt(max(pivot, 1e-12))
        both[j, j] = pivot
        for k in range(j + 1, num + 1):
            value = both[j, k]
            for i in range(j):
                value -= both[i, j] * both[i, k]
            both[j, k] = value / pivot
    for j in range(num - 1, -1, -1):
        value = both[j, num]
        for k in range(j + 1, num):
            value -= both[j, k] * d[k]
        d[j] = value / both[j, j]
    return d


@numba.njit(cache=True, error_model="numpy", nogil=True)
def fit_starts(values, starts, walls, symmetries, first_px, fits, num):  # type: ignore[no-untyped-def]
    """Fit from starts and keep what is new, the best first; return how many there are.

    Args:
        values: Of `BorderRays`, as much of it as is to count.
        starts: (S, 3).
        walls: Of `walls_of`, (W, 8).
        symmetries: x, y, yaw of motions that leave the plan as it is, (M, 3).
        first_px: Residual that halves a weight in the beginning.
        fits: Of `anneal`, the first `num` of (F, 5) count; gets the new ones.
        num: How many there are.
    """
    new = np.empty(5)
    for k in range(len(starts)):
        new[:3], new[3], new[4] = starts[k], 0.0, 1.0
        if first_px > FINE_PX:
            anneal(values, FEW, new, walls, first_px, FINE_PX, np.inf)
        if _same_as(fits, num, new, symmetries) < num:
            continue
        least = np.inf if num == 0 else 1.0 - NEVER * (1.0 - fits[0, 4])
        anneal(values, 1, new, walls, min(first_px, FINE_PX), SPREAD_PX, least)
        if np.isfinite(new).all() and new[4] <= least:
            num = _insert(fits, num, new, symmetries)
    return num


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _same_as(fits, num, new, symmetries):  # type: ignore[no-untyped-def]
    """Return which of the fits a pose is, `num` if none."""
    k = 0
    while k < num and not is_same(fits[k], new, symmetries):
        k += 1
    return k


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _insert(fits, num, new, symmetries):  # type: ignore[no-untyped-def]
    """Put a fit among others, sorted by cost, unless a better one is the same or all are better."""
    k = _same_as(fits, num, new, symmetries)
    if k < num:
        if new[4] >= fits[k, 4]:
            return num
        for j in range(k, num - 1):
            fits[j] = fits[j + 1]
        num -= 1
    if num == len(fits):
        num -= 1
        if new[4] >= fits[num, 4]:
            return num + 1
    k = num
    while k > 0 and fits[k - 1, 4] > new[4]:
        fits[k] = fits[k - 1]
        k -= 1
    fits[k] = new
    return num + 1


@numba.njit(cache=True, error_model="numpy", nogil=True)
def is_same(a, b, symmetries):  # type: ignore[no-untyped-def]
    """Tell whether two poses (3,) are one, or a symmetry of the plan makes them one."""
    for m in range(len(symmetries)):
        x, y, yaw = symmetries[m]
        c, s = math.cos(yaw), math.sin(yaw)
        off_x, off_y = x + c * a[0] - s * a[1] - b[0], y + s * a[0] + c * a[1] - b[1]
        is_turned = math.cos(a[2] + yaw - b[2]) < math.cos(SAME[1])
        if math.hypot(off_x, off_y) < SAME[0] and not is_turned:
            return True
    return False
