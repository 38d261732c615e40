"""Which of a tile's rays end where the lamp does not reach (kernels of `rendering`)."""

from __future__ import annotations

import math

import numba
import numpy as np

from sim_bridge.ray_shapes import is_between, meet, turned


@numba.njit(cache=True, error_model="numpy", inline="always")
def shading_shapes(  # type: ignore[no-untyped-def]
    directions, chosen, num, depth, places, is_glass, lamps, listed
):
    """List the shapes that may stand between a tile's ends and the lamp; return how many."""
    xl = yl = zl = np.inf
    xh = yh = zh = -np.inf
    num_rays = directions.shape[1]
    for k in range(num * num_rays):
        if depth[k] < np.inf:
            p, s, t = chosen[k // num_rays], k % num_rays, depth[k]
            x, y, z = t * directions[p, s, 0], t * directions[p, s, 1], t * directions[p, s, 2]
            xl, yl, zl = min(xl, x), min(yl, y), min(zl, z)
            xh, yh, zh = max(xh, x), max(yh, y), max(zh, z)
    if xl == np.inf:
        return 0
    x, y, z = (xl + xh) / 2.0, (yl + yh) / 2.0, (zl + zh) / 2.0
    reach = math.hypot(math.hypot(xh - x, yh - y), zh - z) + 1e-6
    count = 0
    for i in range(len(places)):
        a, b, c = turned(places, i, x, y, z)
        a, b, c = a + places[i, 9], b + places[i, 10], c + places[i, 11]
        if not is_glass[i] and is_between(
            places, i, a, b, c, lamps[i, 0], lamps[i, 1], lamps[i, 2], reach
        ):
            listed[count] = i
            count += 1
    return count


@numba.njit(cache=True, error_model="numpy", inline="always")
def cast_shadows(  # type: ignore[no-untyped-def]
    directions, chosen, num, depth, hits, places, kinds, lamps, listed, count, shadows
):
    """Mark the rays of a tile whose ends the lamp does not reach; a shape does not shade itself."""
    num_rays = directions.shape[1]
    for k in range(num * num_rays):
        p, s, t = chosen[k // num_rays], k % num_rays, depth[k]
        shadows[k] = False
        if t == np.inf:
            continue
        x, y, z = t * directions[p, s, 0], t * directions[p, s, 1], t * directions[p, s, 2]
        for j in range(count):
            i = listed[j]
            if i == hits[k]:
                continue
            a, b, c = turned(places, i, x, y, z)
            a, b, c = a + places[i, 9], b + places[i, 10], c + places[i, 11]
            way = meet(kinds[i], places, i, a, b, c, lamps[i, 0], lamps[i, 1], lamps[i, 2])
            if way < np.inf:
                shadows[k] = True
                break
