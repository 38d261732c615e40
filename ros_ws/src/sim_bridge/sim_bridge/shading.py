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
PATTERN_UNIT = 2.0  # a pattern at half brightness leaves the color as it is


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


@numba.njit(cache=True, error_model="numpy", nogil=True)
def shade(start, step, bundle, T, shapes, lamps, ground, lighting, atlas, ends, image):  # type: ignore[no-untyped-def]
    """Write the mean color (r, g, b) that the rays of each pixel bring home.

    One function for all rays: handing arrays to a function of one ray costs more than the ray.

    Args:
        start: The first pixel of the bundle that is written.
        step: How many pixels further the next one is.
        bundle: A `Bundle`.
        T: `T_world_camera`.
        shapes: A `Shapes`.
        lamps: Direction to the lamp in each shape's axes.
        ground: Floor and ceiling.
        lighting: The lamp.
        atlas: Textures.
        ends: A `RayEnds`.
        image: What is written, one row a pixel.
    """
    directions, chosen, patch, pixels = (
        bundle.directions, bundle.chosen, bundle.patch, bundle.pixels
    )  # fmt: skip
    places, kinds, textures = shapes.places, shapes.kinds, shapes.textures
    texels, levels, texel_sizes = atlas.texels, atlas.levels, atlas.texel_sizes
    depth, hits, veils, is_shaded = ends.depth, ends.hits, ends.veils, ends.is_shaded
    num_rays = directions.shape[1]
    share = 1.0 / math.sqrt(num_rays)
    for n in range(start, len(chosen), step):
        p, pixel = chosen[n], pixels[chosen[n]]
        image[pixel] = 0.0
        for s in range(num_rays):
            x, y, z = directions[p, s]
            t, i = depth[n, s], hits[n, s]
            edge = t * share * patch[p]
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
            if is_shaded[n, s]:
                lit *= 1.0 - lighting.shadow
            strength, sheen = lighting.ambient + (1.0 - lighting.ambient) * lit, 0.0
            if veils[n, s] > 0:
                through = (1.0 - _PANE_SHARE) ** veils[n, s]
                strength, sheen = through * strength, (1.0 - through) * _SHEEN
            image[pixel, 0] += lighting.color[0] * (strength * r + sheen) / num_rays
            image[pixel, 1] += lighting.color[1] * (strength * g + sheen) / num_rays
            image[pixel, 2] += lighting.color[2] * (strength * b + sheen) / num_rays


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
    u, v = 0.0, 0.0
    if textures[i] >= 0:
        r, g, b = r * PATTERN_UNIT, g * PATTERN_UNIT, b * PATTERN_UNIT
        u, v = place_on_pattern(px, py, pz, nx, ny, nz, hx, hy, hz)
        edge /= math.sqrt(max(abs(nx * dx + ny * dy + nz * dz), 0.05))
    lit = max(nx * lamps[i, 0] + ny * lamps[i, 1] + nz * lamps[i, 2], 0.0)
    return textures[i], r, g, b, lit, u, v, edge


@numba.njit(cache=True, error_model="numpy", inline="always")
def place_on_pattern(px, py, pz, nx, ny, nz, hx, hy, hz):  # type: ignore[no-untyped-def]
    """Return where (u, v) on its pattern a point of a shape is, m.

    Args:
        px: The point in the shape's axes, with py and pz, m.
        py: See px.
        pz: See px.
        nx: The normal there, with ny and nz.
        ny: See nx.
        nz: See nx.
        hx: Half extents of the shape, with hy and hz, m.
        hy: See hx.
        hz: See hx.
    """
    u, v = px, pz + hz
    if abs(nz) > 0.7:
        v = py
    elif abs(nx) > abs(ny):
        u = py
    # Faces and shapes begin at different places of the pattern.
    return u + 7.3 * hx + 3.1 * hy + 2.9 * nx + 1.7 * ny, v


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
