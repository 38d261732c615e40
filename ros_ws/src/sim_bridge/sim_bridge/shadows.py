"""Which rays end where the lamp does not reach (kernels of `rendering`)."""

from __future__ import annotations

import math

import numba
import numpy as np

from sim_bridge.ray_shapes import HALF, is_between, meet, turned


@numba.njit(cache=True, error_model="numpy", nogil=True)
def cast_shadows(start, step, bundle, shapes, lamps, ends):  # type: ignore[no-untyped-def]
    """Mark the rays that end in a shadow, in every `step`th tile from `start` on.

    A shape does not shade itself. `lamps` is the direction to the lamp in each shape's axes.
    """
    directions, chosen, tile_starts = bundle.directions, bundle.chosen, bundle.tile_starts
    places, kinds, is_glass = shapes.places, shapes.kinds, shapes.is_glass
    depth, hits, is_shaded = ends.depth, ends.hits, ends.is_shaded
    listed = np.empty(len(kinds), np.int64)
    for tile in range(start, len(tile_starts) - 1, step):
        first, end = tile_starts[tile], tile_starts[tile + 1]
        count = _shading_shapes(
            directions, chosen, first, end, depth, places, is_glass, lamps, listed
        )
        for n in range(first, end if count else first):
            for s in range(directions.shape[1]):
                t = depth[n, s]
                if t == np.inf:
                    continue
                x, y, z = directions[chosen[n], s]
                for j in range(count):
                    i = listed[j]
                    if i == hits[n, s]:
                        continue
                    a, b, c = turned(places, i, t * x, t * y, t * z)
                    a, b, c = a + places[i, 9], b + places[i, 10], c + places[i, 11]
                    hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
                    lx, ly, lz = lamps[i, 0], lamps[i, 1], lamps[i, 2]
                    if meet(kinds[i], hx, hy, hz, a, b, c, lx, ly, lz) < np.inf:
                        is_shaded[n, s] = True
                        break


@numba.njit(cache=True, error_model="numpy", inline="always")
def _shading_shapes(  # type: ignore[no-untyped-def]
    directions, chosen, first, end, depth, places, is_glass, lamps, listed
):
    """List the shapes that may stand between a tile's ends and the lamp; return how many."""
    xl = yl = zl = np.inf
    xh = yh = zh = -np.inf
    for n in range(first, end):
        for s in range(directions.shape[1]):
            t = depth[n, s]
            if t < np.inf:
                x, y, z = directions[chosen[n], s]
                xl, yl, zl = min(xl, t * x), min(yl, t * y), min(zl, t * z)
                xh, yh, zh = max(xh, t * x), max(yh, t * y), max(zh, t * z)
    x, y, z = (xl + xh) / 2.0, (yl + yh) / 2.0, (zl + zh) / 2.0
    reach = math.hypot(math.hypot(xh - x, yh - y), zh - z) + 1e-6
    count = 0
    for i in range(len(places) if xl < np.inf else 0):
        a, b, c = turned(places, i, x, y, z)
        a, b, c = a + places[i, 9], b + places[i, 10], c + places[i, 11]
        hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
        lx, ly, lz = lamps[i, 0], lamps[i, 1], lamps[i, 2]
        if not is_glass[i] and is_between(hx, hy, hz, a, b, c, lx, ly, lz, reach):
            listed[count] = i
            count += 1
    return count
