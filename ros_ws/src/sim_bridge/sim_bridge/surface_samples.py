"""Points spread evenly over everything that stands still in a world, with their colors.

What a map of the world is made from. Colors are those of the things, without lamp and shadow: their
shares of red, green and blue are those that cameras see.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numba
import numpy as np

from sim_bridge.floor_picture import floor_picture
from sim_bridge.shading import PATTERN_UNIT, place_on_pattern
from sim_bridge.solids import Solid
from sim_bridge.still_shapes import solid_pose
from sim_bridge.textures import PATTERN_TEXEL, pattern
from sim_bridge.world import World


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of surfaces.

    Attributes:
        points: In the world, (N, 3), m.
        colors: RGB, 0..1, (N, 3).
    """

    points: np.ndarray
    colors: np.ndarray


def solid_samples(solid: Solid, spacing: float, depth: float) -> Samples:
    """Return points of a box or cylinder, all faces but the one it stands on.

    Args:
        solid: The solid.
        spacing: Between points, m.
        depth: How far below the surface they are put, so that they lie in the solid.
    """
    faces = list(_round_faces(solid, spacing) if solid.is_round else _box_faces(solid, spacing))
    local, normals = (np.vstack([face[k] for face in faces]) for k in range(2))
    colors = np.tile(np.array(solid.color, dtype=float), (len(local), 1))
    if solid.texture:
        places = np.empty((len(local), 2))
        _places(local, normals, np.array(solid.size) / 2.0, places)
        colors *= PATTERN_UNIT * _texels(pattern(solid.texture), places)
    T = solid_pose(solid)
    inside = local - depth * normals
    return Samples(inside @ T[:3, :3].T + T[:3, 3], np.minimum(colors, 1.0))


def floor_samples(world: World, low: np.ndarray, high: np.ndarray, spacing: float) -> Samples:
    """Return points of the floor from one corner (x, y) to the other, at z = 0."""
    x, y = (_steps(a, b, spacing) for a, b in zip(low, high, strict=True))
    points = _product(x, y, np.zeros(1))
    floor = world.floor
    colors = np.tile(np.array(floor.color, dtype=float), (len(points), 1))
    picture = floor_picture(floor)
    if picture is not None:
        column, row = np.floor((points[:, :2] - floor.from_m) / floor.texel_m).astype(int).T
        on = (column >= 0) & (column < picture.shape[1]) & (row >= 0) & (row < picture.shape[0])
        colors[on] = picture[row[on], column[on]] / 255.0
    return Samples(points, colors)


def _box_faces(solid: Solid, spacing: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    half = np.array(solid.size) / 2.0
    steps = [_steps(-h, h, spacing) for h in half]
    for axis in range(3):
        for side in (-1.0, 1.0):
            if axis == 2 and side < 0.0 and solid.bottom <= 0.0:
                continue
            on = [np.array([side * half[k]]) if k == axis else steps[k] for k in range(3)]
            points = _product(*on)
            yield points, np.tile(side * np.eye(3)[axis], (len(points), 1))


def _round_faces(solid: Solid, spacing: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    radius, half = solid.size[0] / 2.0, solid.size[2] / 2.0
    num = max(math.ceil(2.0 * np.pi * radius / spacing), 8)
    angles = np.arange(num) * 2.0 * np.pi / num
    ring = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(num)))
    heights = _steps(-half, half, spacing)
    side = np.repeat(radius * ring, len(heights), axis=0)
    side[:, 2] = np.tile(heights, num)
    yield side, np.repeat(ring, len(heights), axis=0)
    across = _steps(-radius, radius, spacing)
    disc = _product(across, across, np.array([half]))
    disc = disc[np.hypot(disc[:, 0], disc[:, 1]) <= radius]
    for sign in (1.0,) if solid.bottom <= 0.0 else (1.0, -1.0):
        yield disc * (1.0, 1.0, sign), np.tile((0.0, 0.0, sign), (len(disc), 1))


def _steps(low: float, high: float, spacing: float) -> np.ndarray:
    num = max(math.ceil((high - low) / spacing), 1)
    return np.asarray(low + (np.arange(num) + 0.5) * (high - low) / num)


def _product(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    grids = np.meshgrid(x, y, z, indexing="ij")
    return np.column_stack([grid.ravel() for grid in grids])


def _texels(picture: np.ndarray, places: np.ndarray) -> np.ndarray:
    column, row = np.floor(places / PATTERN_TEXEL).astype(int).T
    height, width = picture.shape[:2]
    return np.asarray(picture[row % height, column % width] / 255.0)


@numba.njit(cache=True, error_model="numpy")
def _places(points, normals, half, places):  # type: ignore[no-untyped-def]
    hx, hy, hz = half
    for i in range(len(points)):
        px, py, pz = points[i]
        nx, ny, nz = normals[i]
        places[i] = place_on_pattern(px, py, pz, nx, ny, nz, hx, hy, hz)
