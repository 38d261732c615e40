"""Surfaces of a map that was made before, as scans are fitted to: where its walls face free space.

A wall is drawn thicker than what the laser saw of it: cells up to the sampled depth behind the
surface are occupied too (label grid), or half of the cell that a beam ended in. The surface is put
half the drawn thickness behind the wall's first edge, at most `MAX_DEPTH_M`.
"""

from __future__ import annotations

import cv2
import numpy as np

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap
from grid_mapper.surface_points import SurfacePoints

EVEN, OCCUPIED_FROM = 50, 65
MAX_DEPTH_M = 0.05
SMOOTH_CELLS = 1.5
ACROSS_M, ALONG_M = 0.03, 0.12
"""Deviations of a surface across and along it."""
MIN_SLOPE = 1e-3


def surfaces_of(grid: OccupancyMap) -> SurfacePoints:
    """Return a point for every occupied cell beside a free one, turned to the free side.

    Args:
        grid: The map.

    Returns:
        Points in the map frame; none where nothing is occupied beside free space.
    """
    occupied, free = is_occupied(grid), is_free(grid)
    near_free = cv2.dilate(free.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    rows, cols = np.nonzero(occupied & near_free)
    blurred = cv2.GaussianBlur(free.astype(np.float32), (0, 0), SMOOTH_CELLS)
    slope_x = cv2.Sobel(blurred, cv2.CV_32F, 1, 0)[rows, cols]
    slope_y = cv2.Sobel(blurred, cv2.CV_32F, 0, 1)[rows, cols]
    slope = np.hypot(slope_x, slope_y)
    is_clear = slope > MIN_SLOPE  # a thin thing free on both sides has no side
    normals = np.zeros((len(rows), 2))
    normals[is_clear] = np.column_stack((slope_x, slope_y))[is_clear] / slope[is_clear, None]
    centers = np.column_stack((cols, rows)) + 0.5
    depth = _depth(occupied, centers, normals) * grid.resolution
    shift = 0.5 * grid.resolution - np.minimum(0.5 * depth, MAX_DEPTH_M)
    points = centers * grid.resolution + shift[:, None] * normals
    local = SurfacePoints(points, _covs(normals), normals)
    return local.moved(grid.origin)


def is_occupied(grid: OccupancyMap) -> np.ndarray:
    """Return which cells are occupied, shape of the map."""
    return np.asarray((grid.cells >= OCCUPIED_FROM) & (grid.cells <= OCCUPIED))


def is_free(grid: OccupancyMap) -> np.ndarray:
    """Return which cells are known to be free, shape of the map."""
    return np.asarray((grid.cells != UNKNOWN) & (grid.cells < EVEN))


def _depth(occupied: np.ndarray, centers: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return how many cells are occupied behind each point, itself counted, shape (N,)."""
    depth = np.ones(len(centers))
    is_on = np.ones(len(centers), bool)
    for step in range(1, 4):
        cells = np.floor(centers - step * normals).astype(int)
        inside = ((cells >= 0) & (cells < occupied.shape[::-1])).all(axis=1)
        cells = np.clip(cells, 0, np.array(occupied.shape[::-1]) - 1)
        is_on &= inside & occupied[cells[:, 1], cells[:, 0]]
        depth += is_on
    return depth


def _covs(normals: np.ndarray) -> np.ndarray:
    """Return rows (xx, xy, yy): thin across, wide along; wide all round without a side."""
    has_side = np.hypot(*normals.T) > 0.5
    nx, ny = normals.T
    along, across = ALONG_M**2, ACROSS_M**2
    covs = np.column_stack(
        (
            along + (across - along) * nx * nx,
            (across - along) * nx * ny,
            along + (across - along) * ny * ny,
        )
    )
    covs[~has_side] = ((0.5 * ALONG_M) ** 2, 0.0, (0.5 * ALONG_M) ** 2)
    return covs


def round_place(points: SurfacePoints, x: float, y: float, reach: float) -> SurfacePoints:
    """Return the points at most `reach` (m) from a place."""
    off = points.points - (x, y)
    near = (off * off).sum(axis=1) <= reach * reach
    return SurfacePoints(points.points[near], points.covs[near], points.normals[near])
