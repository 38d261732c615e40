"""How unlike a pixel of the left image and one of the right are, for every disparity searched.

All matchers here share this cost: the Hamming distance of two census codes (brighter or darker
than the neighbors: what exposure and vignetting leave alone) and the difference of the colors, cut
off where it says no more. The paper names no cost. Costs are bytes, contiguous in the disparity,
so that every step over disparities is one vector instruction after the other.

A disparity d pairs column x of the left image with column x - d of the right one; where that lies
outside of the right image it costs as much as a bad match, `OUTSIDE_COST`.
"""

from __future__ import annotations

import cv2
import numba
import numpy as np
from numba.core import types
from numba.extending import intrinsic

CENSUS_ROWS, CENSUS_COLUMNS = 3, 4
"""How far the census looks up and down, and to both sides, px."""
CENSUS_SHIFT = 1
"""A bit of the census costs 2 to the power of this."""
MAX_COLOR_COST = 30
MAX_COST = 90
OUTSIDE_COST = 30


@intrinsic
def _count_bits(typing_context, value):  # type: ignore[no-untyped-def]
    """Return how many bits of a uint32 are set, as uint32."""

    def generate(context, builder, signature, args):  # type: ignore[no-untyped-def]
        return builder.ctpop(args[0])

    return types.uint32(types.uint32), generate


def matching_costs(left: np.ndarray, right: np.ndarray, num_disparities: int) -> np.ndarray:
    """Return the cost of each disparity at each pixel of the left image.

    Args:
        left: (H, W) or (H, W, 3), uint8.
        right: Of the same shape, rectified: a point lies in the same row of both.
        num_disparities: Disparities 0 to this - 1 are searched.

    Returns:
        (H, W, num_disparities), uint8.
    """
    costs = np.empty((*left.shape[:2], num_disparities), dtype=np.uint8)
    fill_costs(0, len(left), *features(left), *features(right), 0, costs)
    return costs


def features(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what is compared of an image: census codes (H, W) uint32 and colors (H, W, 3)."""
    if image.ndim == 2:
        return census(image), np.repeat(image[:, :, None], 3, axis=2)
    return census(gray_of(image)), np.ascontiguousarray(image)


def first_column(image: np.ndarray) -> int:
    """Return the column where an image begins whose first columns only repeat one another.

    Such are blank borders that rectification left, and columns added for the search: what is
    matched with them is not seen.
    """
    for x in range(image.shape[1] - 1):
        if not np.array_equal(image[:, x], image[:, x + 1]):
            return x
    return 0


def gray_of(image: np.ndarray) -> np.ndarray:
    """Return an image in gray, (H, W), uint8."""
    return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def census(gray: np.ndarray) -> np.ndarray:
    """Return for each pixel which neighbors are darker, every second one of a window.

    Args:
        gray: (H, W), uint8. Beyond its edge it goes on as it is there.

    Returns:
        30 bits, (H, W), uint32.
    """
    rows, columns = CENSUS_ROWS, CENSUS_COLUMNS
    wide = cv2.copyMakeBorder(gray, rows, rows, columns, columns, cv2.BORDER_REPLICATE)
    codes = np.zeros(gray.shape, dtype=np.uint32)
    _fill_census(wide, rows, columns, codes)
    return codes


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _fill_census(wide, rows, columns, codes):  # type: ignore[no-untyped-def]
    height, width = codes.shape
    for y in range(height):
        middle = wide[y + rows, columns : columns + width]
        bit = np.uint32(1)
        for dy in range(2 * rows + 1):
            for dx in range(2 * columns + 1):
                if (dy + dx + rows + columns) % 2 == 1 or (dy == rows and dx == columns):
                    continue
                _compare(wide[y + dy, dx : dx + width], middle, bit, codes[y])
                bit = np.uint32(bit << np.uint32(1))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _compare(neighbors, middle, bit, codes):  # type: ignore[no-untyped-def]
    for x in range(len(codes)):
        if neighbors[x] < middle[x]:
            codes[x] |= bit


@numba.njit(cache=True, error_model="numpy", nogil=True)
def fill_costs(  # type: ignore[no-untyped-def]
    start, stop, left_codes, left_colors, right_codes, right_colors, first_right, costs
):
    """Fill in the costs of rows `start` to `stop`.

    `first_right` is the first column of the right image that shows anything.
    """
    width, num = costs.shape[1], costs.shape[2]
    codes = np.empty(width + num, dtype=np.uint32)
    colors = np.zeros((3, width + num), dtype=np.uint8)
    reds, greens, blues = colors[0], colors[1], colors[2]
    for y in range(start, stop):
        for k in range(width + num):  # backwards, so that a greater disparity comes later
            x = max(width - 1 - k, 0)
            codes[k] = right_codes[y, x]
            reds[k] = right_colors[y, x, 0]
            greens[k] = right_colors[y, x, 1]
            blues[k] = right_colors[y, x, 2]
        for x in range(width):
            k = width - 1 - x
            out = costs[y, x]
            _census_costs(left_codes[y, x], codes[k : k + num], out)
            color = left_colors[y, x]
            _add_color_costs(
                color[0], color[1], color[2], reds[k : k + num], greens[k : k + num],
                blues[k : k + num], out,
            )  # fmt: skip
            out[max(x - first_right + 1, 0) :] = OUTSIDE_COST


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _census_costs(code, codes, out):  # type: ignore[no-untyped-def]
    for d in range(len(out)):
        out[d] = np.uint8(_count_bits(code ^ codes[d]) << np.uint32(CENSUS_SHIFT))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _add_color_costs(red, green, blue, reds, greens, blues, out):  # type: ignore[no-untyped-def]
    limit = np.uint16(MAX_COLOR_COST)
    for d in range(len(out)):
        a = np.uint16(max(red, reds[d]) - min(red, reds[d]))
        b = np.uint16(max(green, greens[d]) - min(green, greens[d]))
        c = np.uint16(max(blue, blues[d]) - min(blue, blues[d]))
        total = np.uint16(np.uint16(np.uint16(a + b) + c) * np.uint16(11)) >> np.uint16(5)
        out[d] = np.uint8(out[d] + np.uint8(min(np.uint16(total), limit)))
