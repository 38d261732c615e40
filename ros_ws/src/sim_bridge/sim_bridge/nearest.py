"""Which point of a shape is nearest, and which such points lie in a cone (kernels of `ray_scene`).

Rows of `places` are as in `ray_shapes`.
"""

from __future__ import annotations

import math

import numba

from sim_bridge.ray_shapes import HALF, turned
from sim_bridge.shape_kinds import BOX, CYLINDER

_INSIDE = 1.0 - 1e-6  # of the half extents: a ray to the very edge may pass it


@numba.njit(cache=True, error_model="numpy")
def nearest_point(kind, hx, hy, hz, ox, oy, oz):  # type: ignore[no-untyped-def]
    """Return the point of a shape with half extents h that is nearest to o, in the shape's axes."""
    hx, hy, hz = _INSIDE * hx, _INSIDE * hy, _INSIDE * hz
    if kind == BOX:
        return max(-hx, min(hx, ox)), max(-hy, min(hy, oy)), max(-hz, min(hz, oz))
    if kind == CYLINDER:
        flat = max(math.hypot(ox, oy), 1e-12)
        share = min(1.0, hx / flat)
        return share * ox, share * oy, max(-hz, min(hz, oz))
    share = min(1.0, hx / max(math.sqrt(ox * ox + oy * oy + oz * oz), 1e-12))
    return share * ox, share * oy, share * oz


@numba.njit(cache=True, error_model="numpy", nogil=True)
def nearest_in_cone(  # type: ignore[no-untyped-def]
    place, axis, cos_half, reach, places, kinds, middles, seen, headings
):
    """Fill rows of headings with unit vectors to the nearest points in a cone; return how many.

    Args:
        place: Tip of the cone in the world, (3,), m.
        axis: Unit vector along it, (3,).
        cos_half: Cosine of its half angle.
        reach: Points farther than this are left out, m.
        places: All shapes.
        kinds: Theirs.
        middles: Theirs in the world, (S, 3), m.
        seen: Rows of the shapes that count.
        headings: Result, with as many rows as `seen`.
    """
    num = 0
    for i in seen:
        mx, my, mz = middles[i, 0] - place[0], middles[i, 1] - place[1], middles[i, 2] - place[2]
        ox, oy, oz = turned(places, i, -mx, -my, -mz)
        hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
        px, py, pz = nearest_point(kinds[i], hx, hy, hz, ox, oy, oz)
        dx, dy, dz = px - ox, py - oy, pz - oz
        far = math.sqrt(dx * dx + dy * dy + dz * dz)
        if far < 1e-6 or far > reach:
            continue
        x = (places[i, 0] * dx + places[i, 3] * dy + places[i, 6] * dz) / far
        y = (places[i, 1] * dx + places[i, 4] * dy + places[i, 7] * dz) / far
        z = (places[i, 2] * dx + places[i, 5] * dy + places[i, 8] * dz) / far
        if x * axis[0] + y * axis[1] + z * axis[2] >= cos_half:
            headings[num, 0], headings[num, 1], headings[num, 2] = x, y, z
            num += 1
    return num
