"""The rays of a camera's pixels, sorted into tiles of neighboring pixels; made once a camera."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

TILE_PX = 8


class Rays(NamedTuple):
    """What a camera's pixels look along.

    Attributes:
        middles: One ray through the middle of each of P pixels, in the camera's frame, (P, 1, 3).
        directions: All rays of each pixel, evenly over its square, (P, S, 3), unit vectors.
        patch: Root of the solid angle of each pixel, (P,), rad.
        pixels: Row-major index of each pixel in its image, (P,), sorted by tile.
        tile_starts: First pixel of each tile, (T + 1,).
        tile_axes: Middle of each tile's rays, (T, 3).
        tile_spreads: How far a ray's tip may be from that middle, (T,).
        is_seen: Pixels that have rays, (height, width).
        refine_above: Pixels take all their rays where light differs by more than this; below 0
            everywhere.
    """

    middles: np.ndarray
    directions: np.ndarray
    patch: np.ndarray
    pixels: np.ndarray
    tile_starts: np.ndarray
    tile_axes: np.ndarray
    tile_spreads: np.ndarray
    is_seen: np.ndarray
    refine_above: float


class Bundle(NamedTuple):
    """Some pixels' rays, as kernels take them.

    Attributes:
        directions: Of the rays of all pixels, (P, S, 3).
        chosen: The N pixels that count, in tile order.
        tile_starts: First of `chosen` in each tile, (T + 1,).
        tile_axes: Of `Rays`.
        tile_spreads: Of `Rays`.
        patch: Of `Rays`.
        pixels: Of `Rays`.
    """

    directions: np.ndarray
    chosen: np.ndarray
    tile_starts: np.ndarray
    tile_axes: np.ndarray
    tile_spreads: np.ndarray
    patch: np.ndarray
    pixels: np.ndarray


class RayEnds(NamedTuple):
    """Where the rays of a bundle end, all (N, S).

    Attributes:
        depth: How far each goes, m; inf if it meets nothing.
        hits: The shape it ends on; -1 for floor, ceiling or nothing.
        veils: How many panes it passes.
        is_shaded: True if the lamp does not reach its end.
    """

    depth: np.ndarray
    hits: np.ndarray
    veils: np.ndarray
    is_shaded: np.ndarray


def coarse_bundle(rays: Rays) -> Bundle:
    """Return one ray of every pixel."""
    every = np.arange(len(rays.pixels))
    return Bundle(
        rays.middles,
        every,
        rays.tile_starts,
        rays.tile_axes,
        rays.tile_spreads,
        rays.patch,
        rays.pixels,
    )


def fine_bundle(rays: Rays, is_wanted: np.ndarray) -> Bundle:
    """Return all rays of the pixels that are wanted, (height, width)."""
    chosen = np.flatnonzero(is_wanted.ravel()[rays.pixels])
    starts = np.searchsorted(chosen, rays.tile_starts)
    return Bundle(
        rays.directions, chosen, starts, rays.tile_axes, rays.tile_spreads, rays.patch, rays.pixels
    )


def empty_ends(bundle: Bundle) -> RayEnds:
    """Return room for where a bundle's rays end; nothing is in shadow."""
    shape = len(bundle.chosen), bundle.directions.shape[1]
    hits, veils = np.empty(shape, np.int64), np.empty(shape, np.uint8)
    return RayEnds(np.empty(shape), hits, veils, np.zeros(shape, np.bool_))


def sorted_rays(directions: np.ndarray, is_seen: np.ndarray, refine_above: float) -> Rays:
    """Sort a camera's rays into tiles.

    Args:
        directions: Unit vectors, shape (height, width, S, 3).
        is_seen: Pixels that see anything, (height, width).
        refine_above: See `Rays`.
    """
    height, width, num_rays, _ = directions.shape
    rows, columns = np.nonzero(is_seen)
    tiles = rows // TILE_PX * (width // TILE_PX + 1) + columns // TILE_PX
    order = np.argsort(tiles, kind="stable")
    pixels = (rows * width + columns)[order]
    starts = np.flatnonzero(np.diff(tiles[order], prepend=-1))
    kept = np.ascontiguousarray(directions.reshape(-1, num_rays, 3)[pixels])
    low = np.minimum.reduceat(kept.min(axis=1), starts)
    high = np.maximum.reduceat(kept.max(axis=1), starts)
    bounds = np.append(starts, len(pixels))
    axes = (low + high) / 2.0
    off = np.linalg.norm(kept - np.repeat(axes, np.diff(bounds), axis=0)[:, None], axis=2)
    spreads = np.maximum.reduceat(off.max(axis=1), starts) + 1e-9
    middle = directions.mean(axis=2)
    patch = np.sqrt(_solid_angles(middle)).ravel()[pixels]
    middles = kept if num_rays == 1 else _unit(kept.mean(axis=1, keepdims=True))
    return Rays(middles, kept, patch, pixels, bounds, axes, spreads, is_seen, refine_above)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _solid_angles(middle: np.ndarray) -> np.ndarray:
    # A single pixel has no neighbors to measure by.
    if min(middle.shape[:2]) < 2:
        return np.ones(middle.shape[:2])
    down, right = np.gradient(middle, axis=(0, 1))
    return np.asarray(np.linalg.norm(np.cross(down, right), axis=-1))
