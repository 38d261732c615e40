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


@numba.njit(cache=True, error_model="numpy")
def shade(  # type: ignore[no-untyped-def]
    x, y, z, t, hit, panes, is_shaded, patch, T, places, kinds, textures, lamps, ground, lighting,
    texels, levels, texel_sizes,
):  # fmt: skip
    """Return the color (r, g, b) that a ray brings home.

    Args:
        x: Its direction in the camera's frame, with y and z.
        y: See x.
        z: See x.
        t: Where it ends, m.
        hit: The shape it ends on; -1 for floor, ceiling or nothing.
        panes: How many panes it passed.
        is_shaded: True if the lamp does not reach its end.
        patch: Root of its solid angle, rad.
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
    """
    if hit >= 0:
        r, g, b, lit = _shape_color(
            x, y, z, t, hit, patch, places, kinds, textures, lamps, texels, levels, texel_sizes
        )
    elif t == np.inf:
        r, g, b = ground.sky_color
        lit = 1.0
    else:
        r, g, b, lit = _plane_color(x, y, z, t, patch, T, ground, texels, levels, texel_sizes)
        lit *= lighting.direction[2]
    if is_shaded:
        lit *= 1.0 - lighting.shadow
    strength, sheen = lighting.ambient + (1.0 - lighting.ambient) * lit, 0.0
    if panes > 0.0:
        through = (1.0 - _PANE_SHARE) ** panes
        strength, sheen = through * strength, (1.0 - through) * _SHEEN
    red, green, blue = lighting.color
    return (
        red * (strength * r + sheen),
        green * (strength * g + sheen),
        blue * (strength * b + sheen),
    )


@numba.njit(cache=True, error_model="numpy")
def _shape_color(  # type: ignore[no-untyped-def]
    x, y, z, t, i, patch, places, kinds, textures, lamps, texels, levels, texel_sizes
):
    """Return the color of a shape where a ray ends, and how far it faces the lamp, 0..1."""
    dx, dy, dz = turned(places, i, x, y, z)
    px, py, pz = places[i, 9] + t * dx, places[i, 10] + t * dy, places[i, 11] + t * dz
    nx, ny, nz = normal_at(kinds[i], places, i, px, py, pz)
    r, g, b = places[i, COLOR], places[i, COLOR + 1], places[i, COLOR + 2]
    if textures[i] >= 0:
        if abs(nz) > 0.7:
            u, v = px, py
        elif abs(nx) > abs(ny):
            u, v = py, pz + places[i, HALF + 2]
        else:
            u, v = px, pz + places[i, HALF + 2]
        facing = max(abs(nx * dx + ny * dy + nz * dz), 0.05)
        # Faces and shapes begin at different places of the pattern.
        u += 7.3 * places[i, HALF] + 3.1 * places[i, HALF + 1] + 2.9 * nx + 1.7 * ny
        p, q, s = sample(
            texels, levels, texel_sizes, textures[i], u, v, t * patch / math.sqrt(facing), True
        )
        r, g, b = r * p * _PATTERN_UNIT, g * q * _PATTERN_UNIT, b * s * _PATTERN_UNIT
    return r, g, b, max(nx * lamps[i, 0] + ny * lamps[i, 1] + nz * lamps[i, 2], 0.0)


@numba.njit(cache=True, error_model="numpy")
def _plane_color(x, y, z, t, patch, T, ground, texels, levels, texel_sizes):  # type: ignore[no-untyped-def]
    """Return the color of floor or ceiling, and 1 for the floor, which faces the lamp."""
    up = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z
    if up > 0.0:
        r, g, b = ground.ceiling_color
        return r, g, b, 0.0
    r, g, b = ground.floor_color
    k = ground.floor_texture
    if k >= 0:
        u = T[0, 3] + t * (T[0, 0] * x + T[0, 1] * y + T[0, 2] * z) - ground.floor_low[0]
        v = T[1, 3] + t * (T[1, 0] * x + T[1, 1] * y + T[1, 2] * z) - ground.floor_low[1]
        size = texel_sizes[k]
        if 0.0 <= u < size * levels[k, 0, 2] and 0.0 <= v < size * levels[k, 0, 1]:
            edge = t * patch / math.sqrt(max(-up, 1e-3))
            r, g, b = sample(texels, levels, texel_sizes, k, u, v, edge, False)
    return r, g, b, 1.0
