"""Pictures by casting each pixel's own rays at boxes, cylinders, spheres, cones and the floor.

A mirror's rays meet in one point but spread as no flat image plane does; casting them directly
needs no cube map and no resampling. Everything is exact but the textures, whose mip level follows
from the patch that a ray stands for. Rays are sorted into tiles of neighboring pixels; only shapes
that a tile's rays can reach are tried there, and only those that can shade what they found.
"""

from __future__ import annotations

from concurrent.futures import Executor
from typing import NamedTuple

import numba
import numpy as np

from sim_bridge.ray_shapes import entry_bound, meet, turned
from sim_bridge.shading import Ground, Lighting, Shapes, shade
from sim_bridge.shadows import cast_shadows, shading_shapes
from sim_bridge.textures import TextureAtlas

TILE_PX = 8


class Rays(NamedTuple):
    """What a camera's pixels look along; made once.

    Attributes:
        directions: Unit vectors in the camera's frame, (P, S, 3): S rays for each of P pixels.
        patch: Root of the solid angle of each ray, (P,), rad.
        pixels: Row-major index of each pixel in its image, (P,), sorted by tile.
        tile_starts: First pixel of each tile, (T + 1,).
        tile_axes: Middle of each tile's rays, (T, 3).
        tile_spreads: How far a ray's tip may be from that middle, (T,).
        height: Rows of the image.
        width: Columns of the image.
    """

    directions: np.ndarray
    patch: np.ndarray
    pixels: np.ndarray
    tile_starts: np.ndarray
    tile_axes: np.ndarray
    tile_spreads: np.ndarray
    height: int
    width: int


def sorted_rays(directions: np.ndarray, is_seen: np.ndarray) -> Rays:
    """Sort a camera's rays into tiles.

    Args:
        directions: Unit vectors, shape (height, width, S, 3).
        is_seen: Pixels that see anything, (height, width).
    """
    height, width, num_rays, _ = directions.shape
    rows, columns = np.nonzero(is_seen)
    tiles = rows // TILE_PX * (width // TILE_PX + 1) + columns // TILE_PX
    order = np.argsort(tiles, kind="stable")
    pixels = (rows * width + columns)[order]
    bounds = np.append(np.flatnonzero(np.diff(tiles[order], prepend=-1)), len(pixels))
    flat = directions.reshape(-1, num_rays, 3)
    axes, spreads = np.zeros((len(bounds) - 1, 3)), np.zeros(len(bounds) - 1)
    for k in range(len(spreads)):
        inside = flat[pixels[bounds[k] : bounds[k + 1]]].reshape(-1, 3)
        axes[k] = (inside.min(axis=0) + inside.max(axis=0)) / 2.0
        spreads[k] = np.linalg.norm(inside - axes[k], axis=1).max() + 1e-9
    patch = np.sqrt(_solid_angles(directions.mean(axis=2)) / num_rays).ravel()[pixels]
    kept = np.ascontiguousarray(flat[pixels])
    return Rays(kept, patch, pixels, bounds, axes, spreads, height, width)


def render(
    rays: Rays,
    T_world_camera: np.ndarray,
    shapes: Shapes,
    ground: Ground,
    lighting: Lighting,
    atlas: TextureAtlas,
    pool: Executor | None = None,
    num_threads: int = 1,
) -> np.ndarray:
    """Return the light that reaches a camera, (height, width, 3) float32, RGB, 1 = white floor.

    Args:
        rays: The camera's.
        T_world_camera: Its pose, (4, 4).
        shapes: Around it, in its frame.
        ground: Floor and ceiling.
        lighting: The lamp.
        atlas: All textures.
        pool: What runs more than one thread; the image does not depend on it.
        num_threads: How many share the tiles.
    """
    image = np.zeros((rays.height * rays.width, 3), dtype=np.float32)
    lamp = T_world_camera[:3, :3].T @ np.array(lighting.direction)
    lamps = shapes.places[:, :9].reshape(-1, 3, 3) @ lamp
    pose = np.ascontiguousarray(T_world_camera)
    arguments = (
        rays.directions, rays.patch, rays.pixels, rays.tile_starts, rays.tile_axes,
        rays.tile_spreads, pose, shapes.places, shapes.kinds, shapes.textures, shapes.is_glass,
        lamps, ground, lighting, atlas.texels, atlas.levels, atlas.texel_sizes, image,
    )  # fmt: skip
    if pool is None:
        _render(0, 1, *arguments)
    else:
        list(pool.map(lambda k: _render(k, num_threads, *arguments), range(num_threads)))
    return image.reshape(rays.height, rays.width, 3)


def _solid_angles(middle: np.ndarray) -> np.ndarray:
    # A single pixel has no neighbors to measure by.
    if min(middle.shape[:2]) < 2:
        return np.ones(middle.shape[:2])
    down, right = np.gradient(middle, axis=(0, 1))
    return np.asarray(np.linalg.norm(np.cross(down, right), axis=-1))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _render(  # type: ignore[no-untyped-def]
    start, step, directions, patch, pixels, tile_starts, tile_axes, tile_spreads, T, places, kinds,
    textures, is_glass, lamps, ground, lighting, texels, levels, texel_sizes, image,
):  # fmt: skip
    num_rays = directions.shape[1]
    most = TILE_PX * TILE_PX * num_rays
    near, depth, veils = np.empty(len(kinds)), np.empty(most), np.empty(most)
    hits, shadows = np.empty(most, np.int64), np.empty(most, np.bool_)
    listed = np.empty(len(kinds), np.int64)
    for tile in range(start, len(tile_spreads), step):
        first, end = tile_starts[tile], tile_starts[tile + 1]
        count = _reached(tile_axes, tile_spreads, tile, places, near, listed)
        _end_rays(
            directions, first, end, T, places, kinds, is_glass, ground.ceiling, listed, count,
            near, depth, hits, veils,
        )  # fmt: skip
        shadows[:] = False
        if lighting.shadow > 0.0:
            count = shading_shapes(directions, first, end, depth, places, is_glass, lamps, listed)
            cast_shadows(
                directions, first, end, depth, hits, places, kinds, lamps, listed, count, shadows
            )
        for p in range(first, end):
            for s in range(num_rays):
                k = (p - first) * num_rays + s
                r, g, b = shade(
                    directions[p, s, 0], directions[p, s, 1], directions[p, s, 2], depth[k],
                    hits[k], veils[k], shadows[k], patch[p], T, places, kinds, textures, lamps,
                    ground, lighting, texels, levels, texel_sizes,
                )  # fmt: skip
                for c, value in enumerate((r, g, b)):
                    image[pixels[p], c] += value / num_rays


@numba.njit(cache=True, error_model="numpy")
def _reached(axes, spreads, tile, places, near, listed):  # type: ignore[no-untyped-def]
    """List the shapes that a tile's rays may reach, nearest first; return how many."""
    count = 0
    for i in range(len(places)):
        dx, dy, dz = turned(places, i, axes[tile, 0], axes[tile, 1], axes[tile, 2])
        bound = entry_bound(places, i, dx, dy, dz, spreads[tile])
        if bound == np.inf:
            continue
        near[i] = bound
        k = count
        while k > 0 and near[listed[k - 1]] > bound:
            listed[k] = listed[k - 1]
            k -= 1
        listed[k] = i
        count += 1
    return count


@numba.njit(cache=True, error_model="numpy")
def _end_rays(  # type: ignore[no-untyped-def]
    directions, first, end, T, places, kinds, is_glass, ceiling, listed, count, near, depth, hits,
    veils,
):  # fmt: skip
    """Fill in where each ray of a tile ends, on what (-1: no shape), behind how many panes."""
    num_rays = directions.shape[1]
    for p in range(first, end):
        for s in range(num_rays):
            x, y, z = directions[p, s, 0], directions[p, s, 1], directions[p, s, 2]
            up = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z
            best, hit, panes = np.inf, -1, 0.0
            if up < 0.0:
                best = -T[2, 3] / up
            elif up > 0.0 and ceiling < np.inf:
                best = (ceiling - T[2, 3]) / up
            for glass in (False, True):
                for k in range(count):
                    i = listed[k]
                    if near[i] > best:
                        break
                    if is_glass[i] != glass:
                        continue
                    dx, dy, dz = turned(places, i, x, y, z)
                    t = meet(
                        kinds[i], places, i, places[i, 9], places[i, 10], places[i, 11], dx, dy, dz
                    )
                    if t < best:
                        if glass:
                            panes += 1.0
                        else:
                            best, hit = t, i
            k = (p - first) * num_rays + s
            depth[k], hits[k], veils[k] = best, hit, panes
