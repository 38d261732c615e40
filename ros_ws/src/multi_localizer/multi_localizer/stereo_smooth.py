"""Disparities freed of what one pixel's noise made of them: small islands, and scatter."""

from __future__ import annotations

import cv2
import numba
import numpy as np

_STEPS = 16  # a pixel; OpenCV's islands are of integers


def drop_islands(disparities: np.ndarray, least_px: int) -> np.ndarray:
    """Return disparities without islands: pieces of fewer pixels than `least_px` become holes.

    A piece goes on while the disparity changes by 1 at most. What one camera alone sees has no
    partner, and pieces that are found there by chance are small.

    Args:
        disparities: (H, W), float32, NaN in holes.
        least_px: 0 or 1 leaves all as it is.
    """
    kept = disparities.copy()
    if least_px <= 1:
        return kept
    steps = np.where(np.isnan(kept), -_STEPS, _STEPS * kept).astype(np.int16)
    cv2.filterSpeckles(steps, -_STEPS, least_px - 1, _STEPS)
    kept[steps < 0] = np.nan
    return kept


def mean_within(disparities: np.ndarray, reach: int, most: float) -> np.ndarray:
    """Return means over squares, along rows and then along columns, of what is nearly the same.

    Args:
        disparities: (H, W), float32, without holes.
        reach: Pixels to each side.
        most: Neighbors that differ by more do not count.
    """
    along_rows, both = np.empty_like(disparities), np.empty_like(disparities)
    _mean_of_rows(disparities, reach, np.float32(most), along_rows)
    _mean_of_columns(along_rows, reach, np.float32(most), both)
    return both


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _mean_of_rows(disparities, reach, most, out):  # type: ignore[no-untyped-def]
    height, width = disparities.shape
    sums, counts = np.empty(width, np.float32), np.empty(width, np.float32)
    for y in range(height):
        sums[:] = 0.0
        counts[:] = 0.0
        row = disparities[y]
        for k in range(-reach, reach + 1):
            first, end = max(0, -k), min(width, width - k)
            if first < end:
                _take(
                    row[first:end], row[first + k : end + k], most, sums[first:end],
                    counts[first:end],
                )  # fmt: skip
        out[y] = sums / counts


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _mean_of_columns(disparities, reach, most, out):  # type: ignore[no-untyped-def]
    height, width = disparities.shape
    sums, counts = np.empty(width, np.float32), np.empty(width, np.float32)
    for y in range(height):
        sums[:] = 0.0
        counts[:] = 0.0
        for k in range(max(-reach, -y), min(reach + 1, height - y)):
            _take(disparities[y], disparities[y + k], most, sums, counts)
        out[y] = sums / counts


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _take(here, there, most, sums, counts):  # type: ignore[no-untyped-def]
    for x in range(len(here)):
        counts_it = np.float32(abs(there[x] - here[x]) <= most)
        sums[x] += counts_it * there[x]
        counts[x] += counts_it
