"""Rays through the layers of a voxel map: what each meets first, and how far.

A ray is followed in units of cells and layers. Beside each free voxel stands how far the next
occupied one of its layer is (in cells, the greater one of rows and columns): the ray leaps out of
that free square, or into the next layer, whichever comes first; where it leaves a square is known
exactly in whole cells, so nothing is stepped over.
"""

from __future__ import annotations

import math

import cv2
import numba
import numpy as np

_FARTHEST_LEAP = 255


def leaps_of(occupied: np.ndarray) -> np.ndarray:
    """Return how far the next occupied voxel of its layer is from each one, in cells.

    Args:
        occupied: (layers, rows, columns), bool.

    Returns:
        Of the same shape, uint8; 0 where occupied, at most 255.
    """
    leaps = np.full(occupied.shape, _FARTHEST_LEAP, dtype=np.uint8)
    for layer, leap in zip(occupied, leaps, strict=True):
        if layer.any():
            far = cv2.distanceTransform((~layer).astype(np.uint8), cv2.DIST_C, 3)
            np.minimum(far, _FARTHEST_LEAP, out=leap, casting="unsafe")
    return leaps


@numba.njit(cache=True, error_model="numpy", inline="always")
def cast_ray(leaps, x, y, z, dx, dy, dz):  # type: ignore[no-untyped-def]
    """Return how often a ray's direction fits until it meets something, and the voxel it meets.

    Args:
        leaps: Of `leaps_of`.
        x: Where it begins, cells from the map's edge.
        y: See x.
        z: The same in layers.
        dx: Direction, cells.
        dy: See dx.
        dz: The same in layers.

    Returns:
        (t, layer, row, column); layer -1 where it leaves the map or begins outside of it.
    """
    layers, rows, columns = leaps.shape
    row, column, layer = int(math.floor(y)), int(math.floor(x)), int(math.floor(z))
    inside = 0 <= layer < layers and 0 <= row < rows and 0 <= column < columns
    way_x = 1.0 / dx if dx != 0.0 else math.inf
    way_y = 1.0 / dy if dy != 0.0 else math.inf
    step_z = 1 if dz > 0.0 else -1
    between_z = abs(1.0 / dz) if dz != 0.0 else math.inf
    next_z = (layer + (dz > 0.0) - z) / dz if dz != 0.0 else math.inf
    t = 0.0
    while inside:
        leap = int(leaps[layer, row, column])
        if leap == 0:
            return t, layer, row, column
        end_x, end_y = math.inf, math.inf
        if dx > 0.0:
            end_x = (column + leap - x) * way_x
        elif dx < 0.0:
            end_x = (column - leap + 1 - x) * way_x
        if dy > 0.0:
            end_y = (row + leap - y) * way_y
        elif dy < 0.0:
            end_y = (row - leap + 1 - y) * way_y
        last_row, last_column = row, column
        t = min(end_x, end_y, next_z)
        if t == math.inf:
            break
        row = min(max(int(math.floor(y + t * dy)), row - leap + 1), row + leap - 1)
        column = min(max(int(math.floor(x + t * dx)), column - leap + 1), column + leap - 1)
        if t == next_z:
            layer += step_z
            next_z += between_z
        elif t == end_x:
            column = last_column + leap if dx > 0.0 else last_column - leap
        else:
            row = last_row + leap if dy > 0.0 else last_row - leap
        inside = 0 <= layer < layers and 0 <= row < rows and 0 <= column < columns
    return t, -1, 0, 0


@numba.njit(cache=True, error_model="numpy", nogil=True)
def cast_views(start, stop, leaps, rgb, scale, eyes, rays, per_pixel, color, distance):  # type: ignore[no-untyped-def]
    """Fill in the views of poses `start` to `stop`: mean color and mean distance of their pixels.

    Args:
        start: First pose.
        stop: Pose after the last one.
        leaps: Of `leaps_of`.
        rgb: (layers, rows, columns, 3), uint8.
        scale: Cells per meter, layers per meter.
        eyes: Where the cameras are, (N, 5): x, y in cells, z in layers, cosine and sine of yaw.
        rays: Slope to the left and up of each ray, (h * per_pixel[0], w * per_pixel[1], 2).
        per_pixel: Rows and columns of rays that a pixel takes.
        color: (N, h, w, 3), float32; mean RGB, 0 where no ray meets anything.
        distance: (N, h, w), float32; mean along the camera's axis, m; NaN where none does.
    """
    tall, wide = per_pixel
    for n in range(start, stop):
        x, y, z, c, s = eyes[n, 0], eyes[n, 1], eyes[n, 2], eyes[n, 3], eyes[n, 4]
        for v in range(color.shape[1]):
            for u in range(color.shape[2]):
                num, far, red, green, blue = 0, 0.0, 0.0, 0.0, 0.0
                for k in range(tall * wide):
                    left, up = rays[v * tall + k // wide, u * wide + k % wide]
                    dx, dy = (c - s * left) * scale[0], (s + c * left) * scale[0]
                    t, layer, i, j = cast_ray(leaps, x, y, z, dx, dy, up * scale[1])
                    if layer >= 0:
                        num += 1
                        far += t
                        red += rgb[layer, i, j, 0]
                        green += rgb[layer, i, j, 1]
                        blue += rgb[layer, i, j, 2]
                distance[n, v, u] = far / num if num > 0 else np.nan
                part = 1.0 / max(num, 1)
                color[n, v, u, 0] = red * part
                color[n, v, u, 1] = green * part
                color[n, v, u, 2] = blue * part
