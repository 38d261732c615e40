"""What color a ray brings home: material, texture, lamp, shadow, panes on the way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from sim_bridge.ray_shapes import COLOR, HALF, normal_at, turned
from sim_bridge.textures import sample

Color = tuple[float, float, float]

_PANE_SHARE = 0.12  # of the light that a pane replaces by its own sheen
_SHEEN = 0.8
_PATTERN_UNIT = 2.0  # a pattern at half brightness leaves the color as it is


class Shapes(NamedTuple):
    """Shapes around a camera.

    Attributes:
        places: Where they are, as in `ray_shapes`, (N, 18).
        kinds: As in `shape_kinds`, (N,).
        textures: Index in the atlas or -1, (N,).
        is_glass: Seen through, (N,).
    """

    places: np.ndarray
    kinds: np.ndarray
    textures: np.ndarray
    is_glass: np.ndarray


class Ground(NamedTuple):
    """Floor, ceiling and what is seen where nothing is.

    Attributes:
        floor_texture: Index in the atlas or -1.
        floor_low: World x, y of the floor picture's first corner, m.
        floor_color: Beyond that picture, RGB.
        ceiling: Height of the ceiling, m; inf for none.
        ceiling_color: RGB.
        sky_color: RGB of rays that hit nothing.
    """

    floor_texture: int
    floor_low: tuple[float, float]
    floor_color: Color
    ceiling: float
    ceiling_color: Color
    sky_color: Color


class Lighting(NamedTuple):
    """One distant lamp and light from everywhere.

    Attributes:
        direction: Unit vector in the world towards the lamp.
        color: RGB factor of all light.
        ambient: Share of light from everywhere.
        shadow: Share of the lamp's light that a shadow takes.
    """

    direction: tuple[float, float, float]
    color: Color
    ambient: float
    shadow: float


@numba.njit(cache=True, error_model="numpy", inline="always")
def shade(  # type: ignore[no-untyped-def]
    directions, chosen, num, depth, hits, veils, shadows, patch, T, places, kinds, textures, lamps,
    ground, lighting, texels, levels, texel_sizes, colors,
):  # fmt: skip
    """Write the color (r, g, b) that each ray of some pixels brings home.

    One function for a whole tile: handing arrays to a function of one ray costs more than the ray.

    Args:
        directions: Of the rays in the camera's frame, (P, S, 3).
        chosen: The pixels, of which the first `num` count.
        num: See chosen.
        depth: Where each ray of those pixels ends, m; pixel by pixel, as all that follow.
        hits: The shape it ends on; -1 for floor, ceiling or nothing.
        veils: How many panes it passed.
        shadows: True if the lamp does not reach its end.
        patch: Root of the solid angle of each pixel, (P,), rad.
        T: `T_world_camera`.
        places: Of `Shapes`, as kinds and textures.
        kinds: See places.
        textures: See places.
        lamps: Direction to the lamp in each shape's axes.
        ground: Floor and ceiling.
        lighting: The lamp.
        texels: Of the atlas, as levels and texel_sizes.
        levels: See texels.
        texel_sizes: See texels.
        colors: What is written, one row a ray.
    """
    num_rays = directions.shape[1]
    share = 1.0 / math.sqrt(num_rays)
    for k in range(num * num_rays):
        p = chosen[k // num_rays]
        x, y, z = directions[p, k % num_rays]
        t, i, edge = depth[k], hits[k], depth[k] * share * patch[p]
        if i >= 0:
            texture, r, g, b, lit, u, v, edge = _shape_at(
                x, y, z, t, edge, i, kinds, places, textures, lamps
            )
        elif t == np.inf:
            (r, g, b), lit, texture, u, v = ground.sky_color, 1.0, -1, 0.0, 0.0
        else:
            texture, r, g, b, lit, u, v, edge = _plane_at(
                x, y, z, t, edge, T, ground, levels, texel_sizes
            )
            lit *= lighting.direction[2]
        if texture >= 0:
            red, green, blue = sample(texels, levels, texel_sizes, texture, u, v, edge, i >= 0)
            r, g, b = r * red, g * green, b * blue
        if shadows[k]:
            lit *= 1.0 - lighting.shadow
        strength, sheen = lighting.ambient + (1.0 - lighting.ambient) * lit, 0.0
        if veils[k] > 0.0:
            through = (1.0 - _PANE_SHARE) ** veils[k]
            strength, sheen = through * strength, (1.0 - through) * _SHEEN
        colors[k, 0] = lighting.color[0] * (strength * r + sheen)
        colors[k, 1] = lighting.color[1] * (strength * g + sheen)
        colors[k, 2] = lighting.color[2] * (strength * b + sheen)


@numba.njit(cache=True, error_model="numpy", inline="always")
def _shape_at(x, y, z, t, edge, i, kinds, places, textures, lamps):  # type: ignore[no-untyped-def]
    """Return what a ray finds on shape i.

    Returns:
        Its texture (-1: none), the color (r, g, b) that this scales, how far the place faces the
        lamp, 0..1, and where (u, v) and how large (edge) the ray's patch is on the texture, m.
    """
    dx, dy, dz = turned(places, i, x, y, z)
    px, py, pz = places[i, 9] + t * dx, places[i, 10] + t * dy, places[i, 11] + t * dz
    hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
    nx, ny, nz = normal_at(kinds[i], hx, hy, hz, px, py, pz)
    r, g, b = places[i, COLOR], places[i, COLOR + 1], places[i, COLOR + 2]
    u, v = px, pz + hz
    if textures[i] >= 0:
        r, g, b = r * _PATTERN_UNIT, g * _PATTERN_UNIT, b * _PATTERN_UNIT
        if abs(nz) > 0.7:
            v = py
        elif abs(nx) > abs(ny):
            u = py
        edge /= math.sqrt(max(abs(nx * dx + ny * dy + nz * dz), 0.05))
        # Faces and shapes begin at different places of the pattern.
        u += 7.3 * hx + 3.1 * hy + 2.9 * nx + 1.7 * ny
    lit = max(nx * lamps[i, 0] + ny * lamps[i, 1] + nz * lamps[i, 2], 0.0)
    return textures[i], r, g, b, lit, u, v, edge


@numba.njit(cache=True, error_model="numpy", inline="always")
def _plane_at(x, y, z, t, edge, T, ground, levels, texel_sizes):  # type: ignore[no-untyped-def]
    """Return what a ray finds on floor or ceiling, as `_shape_at`; only the floor faces a lamp."""
    up = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z
    (r, g, b), lit, texture, u, v = ground.floor_color, 1.0, -1, 0.0, 0.0
    k = ground.floor_texture
    if up > 0.0:
        (r, g, b), lit = ground.ceiling_color, 0.0
    elif k >= 0:
        u = T[0, 3] + t * (T[0, 0] * x + T[0, 1] * y + T[0, 2] * z) - ground.floor_low[0]
        v = T[1, 3] + t * (T[1, 0] * x + T[1, 1] * y + T[1, 2] * z) - ground.floor_low[1]
        size = texel_sizes[k]
        if 0.0 <= u < size * levels[k, 0, 2] and 0.0 <= v < size * levels[k, 0, 1]:
            r, g, b, texture = 1.0, 1.0, 1.0, k
            edge /= math.sqrt(max(-up, 1e-3))
    return texture, r, g, b, lit, u, v, edge
