"""Where a ray meets a shape (kernels of `rendering`).

Row i of `places` holds a shape: the rotation from the camera's frame into the shape's axes (9, row
by row), the camera in those axes (3), half extents (3), color (3). Single numbers are read from it
and passed on: a slice of an array would cost more than the arithmetic. Boxes and the others are
centered; cylinders and cones stand along z, a cone's tip up. A shape that holds the ray's start is
not seen: nothing is drawn from inside.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sim_bridge.shape_kinds import BOX, CYLINDER, SPHERE

HALF, COLOR = 12, 15
NUM_COLUMNS = 18
_NONE = np.inf


@numba.njit(cache=True, error_model="numpy", inline="always")
def turned(places, i, x, y, z):  # type: ignore[no-untyped-def]
    """Return a vector of the camera's frame in the axes of shape i."""
    a = places[i, 0] * x + places[i, 1] * y + places[i, 2] * z
    b = places[i, 3] * x + places[i, 4] * y + places[i, 5] * z
    c = places[i, 6] * x + places[i, 7] * y + places[i, 8] * z
    return a, b, c


@numba.njit(cache=True, error_model="numpy")
def meet(kind, hx, hy, hz, ox, oy, oz, dx, dy, dz):  # type: ignore[no-untyped-def]
    """Return the distance at which a ray enters a shape; inf if it does not.

    Args:
        kind: As in `shape_kinds`.
        hx: Half extents of the shape, with hy and hz.
        hy: See hx.
        hz: See hx.
        ox: Start of the ray in the shape's axes, with oy and oz.
        oy: See ox.
        oz: See ox.
        dx: Its direction, with dy and dz.
        dy: See dx.
        dz: See dx.
    """
    if kind == BOX:
        xn, xf = _slab(ox, dx, hx)
        yn, yf = _slab(oy, dy, hy)
        zn, zf = _slab(oz, dz, hz)
        near = max(xn, max(yn, zn))
        return near if 0.0 < near <= min(xf, min(yf, zf)) else _NONE
    if kind == CYLINDER:
        return _meet_cylinder(hx, hz, ox, oy, oz, dx, dy, dz)
    if kind == SPHERE:
        return _meet_sphere(hx, ox, oy, oz, dx, dy, dz)
    return _meet_cone(hx, hz, ox, oy, oz, dx, dy, dz)


@numba.njit(cache=True, error_model="numpy", inline="always")
def _slab(o, d, half):  # type: ignore[no-untyped-def]
    """Return where a ray enters and leaves the space between two planes."""
    if d == 0.0:
        return (-np.inf, np.inf) if abs(o) <= half else (np.inf, -np.inf)
    a, b = (-half - o) / d, (half - o) / d
    return min(a, b), max(a, b)


@numba.njit(cache=True, error_model="numpy")
def _meet_cylinder(radius, tall, ox, oy, oz, dx, dy, dz):  # type: ignore[no-untyped-def]
    near, far = _slab(oz, dz, tall)
    a = dx * dx + dy * dy
    b, c = ox * dx + oy * dy, ox * ox + oy * oy - radius * radius
    if a > 0.0:
        root = b * b - a * c
        if root < 0.0:
            return _NONE
        root = math.sqrt(root)
        near, far = max(near, (-b - root) / a), min(far, (-b + root) / a)
    elif c > 0.0:
        return _NONE
    return near if 0.0 < near <= far else _NONE


@numba.njit(cache=True, error_model="numpy")
def _meet_sphere(radius, ox, oy, oz, dx, dy, dz):  # type: ignore[no-untyped-def]
    b = ox * dx + oy * dy + oz * dz
    root = b * b - (ox * ox + oy * oy + oz * oz - radius * radius)
    if root < 0.0:
        return _NONE
    near = -b - math.sqrt(root)
    return near if near > 0.0 else _NONE


@numba.njit(cache=True, error_model="numpy")
def _meet_cone(radius, tall, ox, oy, oz, dx, dy, dz):  # type: ignore[no-untyped-def]
    k = radius / (2.0 * tall)  # radius per height below the tip
    w, dw = tall - oz, -dz
    a = dx * dx + dy * dy - k * k * dw * dw
    b = ox * dx + oy * dy - k * k * w * dw
    c = ox * ox + oy * oy - k * k * w * w
    best = _NONE
    if a != 0.0 and b * b - a * c >= 0.0:
        root = math.sqrt(b * b - a * c)
        for t in ((-b - root) / a, (-b + root) / a):
            if 0.0 < t < best and abs(oz + t * dz) <= tall:
                best = t
    if dz != 0.0:
        t = (-tall - oz) / dz
        x, y = ox + t * dx, oy + t * dy
        if 0.0 < t < best and x * x + y * y <= radius * radius:
            best = t
    return best


@numba.njit(cache=True, error_model="numpy")
def normal_at(kind, hx, hy, hz, px, py, pz):  # type: ignore[no-untyped-def]
    """Return the outward normal at a point (p) of a shape's surface with half extents h."""
    if kind == BOX:
        x, y, z = abs(px) / hx, abs(py) / hy, abs(pz) / hz
        if x >= y and x >= z:
            return math.copysign(1.0, px), 0.0, 0.0
        if y >= z:
            return 0.0, math.copysign(1.0, py), 0.0
        return 0.0, 0.0, math.copysign(1.0, pz)
    if kind == SPHERE:
        return px / hx, py / hx, pz / hx
    flat = max(math.hypot(px, py), 1e-12)
    if kind == CYLINDER:
        if flat / hx >= abs(pz) / hz:
            return px / flat, py / flat, 0.0
        return 0.0, 0.0, math.copysign(1.0, pz)
    if pz < -hz * (1.0 - 1e-9):
        return 0.0, 0.0, -1.0
    slope = math.hypot(2.0 * hz, hx)
    side = 2.0 * hz / slope / flat
    return side * px, side * py, hx / slope


@numba.njit(cache=True, error_model="numpy")
def entry_bound(places, i, dx, dy, dz, spread):  # type: ignore[no-untyped-def]
    """Return what no ray of a bundle is short of where it enters the box of shape i; inf if none.

    Args:
        places: All shapes.
        i: The shape.
        dx: Middle of the directions in its axes, with dy and dz.
        dy: See dx.
        dz: See dx.
        spread: How far a direction may be from the middle.
    """
    near, far = 0.0, np.inf
    for k in range(3):
        o, half = places[i, 9 + k], places[i, HALF + k]
        d = dx if k == 0 else (dy if k == 1 else dz)
        if o < 0.0:
            o, d = -o, -d
        slow, fast = d - spread, d + spread  # towards the box is negative
        if o > half:
            if slow >= 0.0:
                return _NONE
            near = max(near, (o - half) / -slow)
            if fast < 0.0:
                far = min(far, (o + half) / -fast)
        elif slow > 0.0:
            far = min(far, (half - o) / slow)
        elif fast < 0.0:
            far = min(far, (half + o) / -fast)
    return near if near <= far else _NONE


@numba.njit(cache=True, error_model="numpy")
def is_between(hx, hy, hz, x, y, z, lx, ly, lz, reach):  # type: ignore[no-untyped-def]
    """Tell whether the box of half extents h may stand between a point and the lamp.

    The point is (x, y, z) in the box's axes, or any within `reach`; the lamp is towards l.
    """
    xn, xf = _slab(x, lx, hx + reach)
    yn, yf = _slab(y, ly, hy + reach)
    zn, zf = _slab(z, lz, hz + reach)
    return max(max(xn, 0.0), max(yn, zn)) <= min(xf, min(yf, zf))
