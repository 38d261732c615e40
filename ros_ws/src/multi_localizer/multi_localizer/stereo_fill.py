"""Holes of a disparity image, filled by one rule for every method: from the farther neighbor."""

from __future__ import annotations

import numba
import numpy as np


def fill_from_farther(disparities: np.ndarray) -> np.ndarray:
    """Return a disparity image without holes.

    A hole takes the smaller one of the next known disparities to its left and right: what a camera
    does not see is the background. A row without any takes the values of the nearest row that has.

    Args:
        disparities: (H, W), float32, NaN in holes.

    Returns:
        Of the same shape; all NaN only if nothing is known.
    """
    filled = np.array(disparities, dtype=np.float32)
    fill_rows(filled)
    known = np.flatnonzero(~np.isnan(filled[:, 0])) if filled.size else np.empty(0, np.int64)
    if 0 < len(known) < len(filled):
        for y in np.flatnonzero(np.isnan(filled[:, 0])):
            filled[y] = filled[known[np.argmin(np.abs(known - y))]]
    return filled


@numba.njit(cache=True, error_model="numpy", nogil=True)
def fill_rows(disparities):  # type: ignore[no-untyped-def]
    """Fill the holes of each row in place, from the farther neighbor."""
    height, width = disparities.shape
    for y in range(height):
        row = disparities[y]
        start = 0  # of the hole
        for x in range(width + 1):
            if x < width and np.isnan(row[x]):
                continue
            if x > start:
                left = row[start - 1] if start > 0 else np.float32(np.inf)
                right = row[x] if x < width else np.float32(np.inf)
                farther = min(left, right)
                row[start:x] = farther if farther < np.inf else np.float32(np.nan)
            start = x + 1
