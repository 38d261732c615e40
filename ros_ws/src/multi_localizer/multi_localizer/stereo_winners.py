"""From sums over disparities to disparities: the best, seen from both images, between pixels."""

from __future__ import annotations

import numba
import numpy as np

NONE = np.uint32(2**32 - 1)
DISPARITY_BITS = np.uint32(8)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def pick_winners(sums, max_difference, first_right, seen_right, out):  # type: ignore[no-untyped-def]
    """Fill in the disparities of a row; NaN where the right image disagrees.

    A pixel is hidden from the right camera if its partner's own best disparity differs by more than
    `max_difference`, or if the partner lies outside of the right image.

    Args:
        sums: (W, D), uint16.
        max_difference: Pixels.
        first_right: First column of the right image that shows anything.
        seen_right: Memory, (W + D,), uint32.
        out: (W,), float32.
    """
    width, num = sums.shape
    seen_right[:] = NONE
    for x in range(width):
        first = width - 1 - x
        _see_from_right(sums[x], seen_right[first : first + num])
        out[x] = _least(sums[x])
    for x in range(width):
        d = int(out[x])
        partner = x - d
        if partner < first_right:
            out[x] = np.nan
            continue
        seen = np.int64(seen_right[width - 1 - partner] & np.uint32(255))
        if abs(seen - d) > max_difference:
            out[x] = np.nan
        elif 0 < d < num - 1:
            out[x] += offset(sums[x, d - 1], sums[x, d], sums[x, d + 1])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _see_from_right(sums, seen):  # type: ignore[no-untyped-def]
    """Keep the least sum of each right pixel, its disparity in the last bits.

    Right pixels stand backwards, so that those of greater disparities come later.
    """
    for d in range(len(sums)):
        value = np.uint32(np.uint32(sums[d]) << DISPARITY_BITS) | np.uint32(d)
        seen[d] = min(seen[d], np.uint32(value))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _least(sums):  # type: ignore[no-untyped-def]
    """Return the first disparity that has the least sum."""
    least = np.uint16(65535)
    for d in range(len(sums)):
        least = min(least, sums[d])
    for d in range(len(sums)):
        if sums[d] == least:
            return d
    return 0


@numba.njit(cache=True, error_model="numpy", nogil=True)
def offset(before, least, after):  # type: ignore[no-untyped-def]
    """Return where between two pixels the least lies, by two lines of one slope, -0.5 to 0.5.

    0 where the middle one is not the least.
    """
    down, up = np.int64(before) - np.int64(least), np.int64(after) - np.int64(least)
    if min(down, up) < 0:
        return np.float32(0.0)
    steeper = max(down, up)
    return np.float32(0.0) if steeper == 0 else np.float32(0.5 * (down - up) / steeper)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def refine(start, stop, costs, out):  # type: ignore[no-untyped-def]
    """Move whole disparities of rows `start` to `stop` between pixels, to the least of the costs.

    Args:
        start: First row.
        stop: Row after the last one.
        costs: (H, W, D), uint8.
        out: (H, W), float32, NaN in holes.
    """
    last = costs.shape[2] - 1
    for y in range(start, stop):
        for x in range(costs.shape[1]):
            if np.isnan(out[y, x]):
                continue
            d = int(out[y, x])
            if 0 < d < last:
                out[y, x] += offset(costs[y, x, d - 1], costs[y, x, d], costs[y, x, d + 1])
