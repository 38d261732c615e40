"""What a pair of cameras saw, reduced to the 320 x 8 pixels that are held against the map.

The paper handles camera views "as a resolution of 320 x 8" and says no more (section 3.3.1): here a
pixel of the view is a block of the image. Its color is the mean of the block, its distance the mean
of those that are known; beside them stands the median disparity as an inverse distance, which a few
wrong matches in the block do not move and whose error does not grow with distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from multi_localizer.voxel_view import ViewCamera

VIEW_COLUMNS, VIEW_ROWS = 320, 8


@dataclass(frozen=True, eq=False)
class StereoView:
    """A view of one pair.

    Attributes:
        color: Mean RGB, 0..255, (h, w, 3), float32.
        distance: Mean along the camera's axis, (h, w), float32, m; NaN where none is known.
        inverse: Median of one over it, (h, w), float32, 1/m; NaN where none is known.
        weight: Share of the block whose disparity is known, (h, w), float32.
    """

    color: np.ndarray
    distance: np.ndarray
    inverse: np.ndarray
    weight: np.ndarray


def observe(
    disparity: np.ndarray,
    left: np.ndarray,
    camera: ViewCamera,
    farthest_m: float,
    size: tuple[int, int] = (VIEW_COLUMNS, VIEW_ROWS),
) -> StereoView:
    """Return what a pair saw as a view.

    Args:
        disparity: (H, W), float32, px, of the left image; NaN where there is none.
        left: (H, W, 3), RGB, uint8.
        camera: The left camera.
        farthest_m: Nothing is farther: what a smaller disparity says is put there.
        size: Columns and rows of the view; where the image has fewer, its pixels stand in several.

    Raises:
        ValueError: If the images are not of the camera's size, or the view has no pixels.
    """
    shape = camera.height_px, camera.width_px
    if disparity.shape != shape or left.shape != (*shape, 3):
        raise ValueError(
            f"images must be {shape} as the camera's, got {disparity.shape} and {left.shape}"
        )
    columns, rows = size
    if columns < 1 or rows < 1:
        raise ValueError(f"a view must have at least one column and row, got {size}")
    color = np.empty((rows, columns, 3), dtype=np.float32)
    distance, inverse, weight = (np.empty((rows, columns), dtype=np.float32) for _ in range(3))
    least = camera.pixel_meters / farthest_m
    shifted = disparity.astype(np.float32) - np.float32(camera.disparity_offset_px)
    seen = np.maximum(shifted, np.float32(least)) / np.float32(camera.pixel_meters)
    image = np.array(left, dtype=np.uint8, order="C")
    _reduce(
        seen, image, _blocks(shape[0], rows), _blocks(shape[1], columns), color, distance, inverse,
        weight,
    )  # fmt: skip
    return StereoView(color, distance, inverse, weight)


def coarser(view: StereoView, size: tuple[int, int]) -> StereoView:
    """Return a view of fewer pixels: means over blocks, of distances where they are known.

    Raises:
        ValueError: If the view has not a whole number of pixels for each new one.
    """
    rows, columns = view.weight.shape
    if columns % size[0] != 0 or rows % size[1] != 0:
        raise ValueError(f"{size} must divide the view's {(columns, rows)}")
    blocks = (size[1], rows // size[1], size[0], columns // size[0])
    share = view.weight.reshape(blocks).mean(axis=(1, 3))

    def mean(values: np.ndarray) -> np.ndarray:
        known = np.where(view.weight > 0.0, values * view.weight, 0.0)
        total = known.reshape(blocks).mean(axis=(1, 3))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(total / share, dtype=np.float32)

    color = view.color.reshape(*blocks, 3).mean(axis=(1, 3))
    return StereoView(color, mean(view.distance), mean(view.inverse), share)


def _blocks(length: int, num: int) -> np.ndarray:
    """Return the first pixel of each of `num` blocks and the one after its last, (num, 2).

    Edges between pixels are rounded, so that the middles of the blocks are on average where
    `ViewCamera.rays` has them.
    """
    if num > length:
        middles = np.floor((np.arange(num) + 0.5) * length / num).astype(np.int64)
        return np.stack((middles, middles + 1), axis=1)
    edges = np.rint(np.linspace(0, length, num + 1)).astype(np.int64)
    return np.stack((edges[:-1], edges[1:]), axis=1)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _reduce(seen, image, rows, columns, color, distance, inverse, weight):  # type: ignore[no-untyped-def]
    """Fill in a view from inverse distances (H, W), NaN where unknown, and an image, by blocks."""
    known = np.empty(seen.size, dtype=np.float32)
    for v in range(color.shape[0]):
        for u in range(color.shape[1]):
            total, num, far, red, green, blue = 0, 0, 0.0, 0.0, 0.0, 0.0
            for y in range(rows[v, 0], rows[v, 1]):
                for x in range(columns[u, 0], columns[u, 1]):
                    total += 1
                    red += image[y, x, 0]
                    green += image[y, x, 1]
                    blue += image[y, x, 2]
                    if not np.isnan(seen[y, x]):
                        known[num] = seen[y, x]
                        far += 1.0 / seen[y, x]
                        num += 1
            color[v, u, 0], color[v, u, 1], color[v, u, 2] = (
                red / total,
                green / total,
                blue / total,
            )
            weight[v, u] = num / total
            distance[v, u] = far / num if num > 0 else np.nan
            inverse[v, u] = np.median(known[:num]) if num > 0 else np.nan
