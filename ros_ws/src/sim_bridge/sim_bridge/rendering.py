"""Pictures by casting each pixel's own rays at boxes, cylinders, spheres, cones and the floor.

A mirror's rays meet in one point but spread as no flat image plane does; casting them directly
needs no cube map and no resampling. Everything is exact but the textures, whose mip level follows
from the patch that a ray stands for. Rays are sorted into tiles of neighboring pixels; only shapes
that a tile's rays can reach are tried there, and only those that can shade what they found.

Every pixel first takes one ray; where the light of neighbors differs both take all of theirs. What
is thinner than a pixel and falls between the middles of all pixels near it is so missed.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor

import numba
import numpy as np

from sim_bridge.camera_rays import Bundle, Rays, coarse_bundle, empty_ends, fine_bundle
from sim_bridge.ray_shapes import HALF, entry_bound, meet, turned
from sim_bridge.shading import Ground, Lighting, Shapes, shade
from sim_bridge.shadows import cast_shadows
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
    T = np.ascontiguousarray(T_world_camera)
    lamp = T[:3, :3].T @ np.array(lighting.direction)
    lamps = shapes.places[:, :9].reshape(-1, 3, 3) @ lamp

    def draw(bundle: Bundle) -> None:
        ends = empty_ends(bundle)

        def draw_part(start: int, step: int) -> None:
            _end_rays(start, step, bundle, T, shapes, ground.ceiling, ends)
            if lighting.shadow > 0.0:
                cast_shadows(start, step, bundle, shapes, lamps, ends)

        def color_part(start: int, step: int) -> None:
            shade(
                start, step, bundle, T, shapes, lamps, ground, lighting, atlas, ends,
                image.reshape(-1, 3),
            )  # fmt: skip

        _in_parts(pool, num_threads, draw_part)
        _in_parts(pool, num_threads, color_part)

    if rays.refine_above >= 0.0 or rays.directions.shape[1] == 1:
        draw(coarse_bundle(rays))
    if rays.directions.shape[1] > 1:
        draw(fine_bundle(rays, _uneven(image, rays.is_seen, rays.refine_above)))
    return image


def _in_parts(pool: Executor | None, num: int, do: Callable[[int, int], None]) -> None:
    """Call do(k, num) for all k < num, all at once if there is a pool."""
    if pool is None:
        do(0, 1)
    else:
        list(pool.map(do, range(num), [num] * num))


def _uneven(image: np.ndarray, is_seen: np.ndarray, most: float) -> np.ndarray:
    """Mark the pixels whose light differs by more than `most` from that of a neighbor."""
    marked = np.full(is_seen.shape, most < 0.0)
    for here, there in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        red, green, blue = np.moveaxis(np.abs(image[here] - image[there]) > most, -1, 0)
        differs = (red | green | blue) & is_seen[here] & is_seen[there]
        marked[here] |= differs
        marked[there] |= differs
    return marked


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _end_rays(start, step, bundle, T, shapes, ceiling, ends):  # type: ignore[no-untyped-def]
    """Fill in where each ray ends and what it passes, in every `step`th tile from `start` on."""
    directions, chosen, tile_starts = bundle.directions, bundle.chosen, bundle.tile_starts
    axes, spreads = bundle.tile_axes, bundle.tile_spreads
    places, kinds, is_glass = shapes.places, shapes.kinds, shapes.is_glass
    depth, hits, veils = ends.depth, ends.hits, ends.veils
    near, listed = np.empty(len(kinds)), np.empty(len(kinds), np.int64)
    for tile in range(start, len(spreads), step):
        first, end = tile_starts[tile], tile_starts[tile + 1]
        count = 0 if first == end else _reached(axes, spreads, tile, places, near, listed)
        for n in range(first, end):
            for s in range(directions.shape[1]):
                x, y, z = directions[chosen[n], s]
                up = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z
                best, hit, panes = np.inf, -1, 0
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
                        hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
                        ox, oy, oz = places[i, 9], places[i, 10], places[i, 11]
                        t = meet(kinds[i], hx, hy, hz, ox, oy, oz, dx, dy, dz)
                        if t < best:
                            if glass:
                                panes += 1
                            else:
                                best, hit = t, i
                depth[n, s], hits[n, s], veils[n, s] = best, hit, panes


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
