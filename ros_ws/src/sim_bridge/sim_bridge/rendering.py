"""Pictures by casting each pixel's own rays at boxes, cylinders, spheres, cones and the floor.

A mirror's rays meet in one point but spread as no flat image plane does; casting them directly
needs no cube map and no resampling. Everything is exact but the textures, whose mip level follows
from the patch that a ray stands for. Rays are sorted into tiles of neighboring pixels; only shapes
that a tile's rays can reach are tried there, and only those that can shade what they found.

Every pixel first takes one ray; where the light of neighbors differs both take all of theirs. What
is thinner than a pixel and falls between the middles of all pixels near it is so missed.
"""

from __future__ import annotations

from concurrent.futures import Executor

import numba
import numpy as np

from sim_bridge.camera_rays import TILE_PX, Rays
from sim_bridge.ray_shapes import entry_bound, meet, turned
from sim_bridge.shading import Ground, Lighting, Shapes, shade
from sim_bridge.shadows import cast_shadows, shading_shapes
from sim_bridge.textures import TextureAtlas


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
    image = np.zeros((*rays.is_seen.shape, 3), dtype=np.float32)
    lamp = T_world_camera[:3, :3].T @ np.array(lighting.direction)
    lamps = shapes.places[:, :9].reshape(-1, 3, 3) @ lamp
    pose = np.ascontiguousarray(T_world_camera)
    arguments = (
        rays.patch, rays.pixels, rays.tile_starts, rays.tile_axes, rays.tile_spreads, pose,
        shapes.places, shapes.kinds, shapes.textures, shapes.is_glass, lamps, ground, lighting,
        atlas.texels, atlas.levels, atlas.texel_sizes, image.reshape(-1, 3),
    )  # fmt: skip

    def draw(directions: np.ndarray, is_wanted: np.ndarray) -> None:
        if pool is None:
            _draw(0, 1, directions, is_wanted, *arguments)
        else:
            jobs = (pool.submit(_draw, k, num_threads, directions, is_wanted, *arguments)
                    for k in range(num_threads))  # fmt: skip
            for job in list(jobs):
                job.result()

    if rays.refine_above >= 0.0 or rays.directions.shape[1] == 1:
        draw(rays.middles, np.ones(rays.is_seen.shape, dtype=bool))
    if rays.directions.shape[1] > 1:
        draw(rays.directions, _uneven(image, rays.is_seen, rays.refine_above))
    return image


@numba.njit(cache=True, error_model="numpy")
def _uneven(image, is_seen, most):  # type: ignore[no-untyped-def]
    """Mark the pixels whose light differs by more than `most` from that of a neighbor."""
    height, width = is_seen.shape
    marked = np.full((height, width), most < 0.0)
    for i in range(height):
        for j in range(width):
            for ni, nj in ((i + 1, j), (i, j + 1)):
                if ni < height and nj < width and is_seen[i, j] and is_seen[ni, nj]:
                    for c in range(3):
                        if abs(image[i, j, c] - image[ni, nj, c]) > most:
                            marked[i, j] = marked[ni, nj] = True
    return marked


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _draw(  # type: ignore[no-untyped-def]
    start, step, directions, is_wanted, patch, pixels, tile_starts, tile_axes, tile_spreads, T,
    places, kinds, textures, is_glass, lamps, ground, lighting, texels, levels, texel_sizes, image,
):  # fmt: skip
    """Draw the wanted pixels of every `step`th tile from `start` on, each with all its rays."""
    num_rays = directions.shape[1]
    most = TILE_PX * TILE_PX * num_rays
    near, depth, veils = np.empty(len(kinds)), np.empty(most), np.empty(most)
    hits, shadows = np.empty(most, np.int64), np.zeros(most, np.bool_)
    listed, chosen = np.empty(len(kinds), np.int64), np.empty(TILE_PX * TILE_PX, np.int64)
    colors, wanted = np.empty((most, 3)), is_wanted.reshape(-1)
    for tile in range(start, len(tile_spreads), step):
        num = 0
        for p in range(tile_starts[tile], tile_starts[tile + 1]):
            if wanted[pixels[p]]:
                chosen[num] = p
                num += 1
        if num == 0:
            continue
        count = _reached(tile_axes, tile_spreads, tile, places, near, listed)
        _end_rays(
            directions, chosen, num, T, places, kinds, is_glass, ground.ceiling, listed, count,
            near, depth, hits, veils,
        )  # fmt: skip
        if lighting.shadow > 0.0:
            count = shading_shapes(directions, chosen, num, depth, places, is_glass, lamps, listed)
            cast_shadows(
                directions, chosen, num, depth, hits, places, kinds, lamps, listed, count, shadows
            )
        shade(
            directions, chosen, num, depth, hits, veils, shadows, patch, T, places, kinds,
            textures, lamps, ground, lighting, texels, levels, texel_sizes, colors,
        )  # fmt: skip
        for j in range(num):
            for c in range(3):
                total = 0.0
                for k in range(j * num_rays, (j + 1) * num_rays):
                    total += colors[k, c]
                image[pixels[chosen[j]], c] = total / num_rays


@numba.njit(cache=True, error_model="numpy", inline="always")
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


@numba.njit(cache=True, error_model="numpy", inline="always")
def _end_rays(  # type: ignore[no-untyped-def]
    directions, chosen, num, T, places, kinds, is_glass, ceiling, listed, count, near, depth, hits,
    veils,
):  # fmt: skip
    """Fill in where each ray of a tile ends, on what (-1: no shape), behind how many panes."""
    num_rays = directions.shape[1]
    for ray in range(num * num_rays):
        x, y, z = directions[chosen[ray // num_rays], ray % num_rays]
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
                ox, oy, oz = places[i, 9], places[i, 10], places[i, 11]
                t = meet(kinds[i], places, i, ox, oy, oz, dx, dy, dz)
                if t < best:
                    if glass:
                        panes += 1.0
                    else:
                        best, hit = t, i
        depth[ray], hits[ray], veils[ray] = best, hit, panes
