"""Monotone DP along whole scanlines: what the paper holds its own method against (section 2).

The matching of Ohta and Kanade (the paper's reference 1) with single pixels for intervals, in the
form of Cox et al. (1996): a path through (column, disparity) either pairs a pixel of the left row
with one of the right row, or leaves a pixel of one of them without a partner for `occlusion`. Order
never reverses: from one column to the next the disparity grows by 1 at most, and only where the
left pixel is hidden from the right camera.
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, error_model="numpy", nogil=True)
def match_monotone(start, stop, costs, occlusion, out):  # type: ignore[no-untyped-def]
    """Fill in disparities of rows `start` to `stop`; NaN where the right camera sees nothing.

    Args:
        start: First row.
        stop: Row after the last one.
        costs: (H, W, D), uint8.
        occlusion: Cost of a pixel without a partner.
        out: (H, W), float32.
    """
    width, num = costs.shape[1], costs.shape[2]
    sums = np.empty((width, num), dtype=np.int32)
    entry = np.empty(num, dtype=np.int32)
    for y in range(start, stop):
        for d in range(num):
            sums[0, d] = costs[y, 0, d]
        for x in range(1, width):
            _enter(sums[x - 1], occlusion, entry)
            _extend(costs[y, x], entry, sums[x - 1], occlusion, sums[x])
        _trace_back(costs[y], sums, occlusion, out[y])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _enter(before, occlusion, entry):  # type: ignore[no-untyped-def]
    """Fill in the least sum with which each disparity is reached, right pixels left out."""
    best = before[len(before) - 1]
    entry[len(before) - 1] = best
    for k in range(len(before) - 1):
        d = len(before) - 2 - k
        best = min(before[d], np.int32(best + occlusion))
        entry[d] = best


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _extend(cost, entry, before, occlusion, after):  # type: ignore[no-untyped-def]
    """Fill in the sums after one more left pixel: paired, or hidden from the right camera."""
    after[0] = entry[0] + cost[0]
    for d in range(1, len(after)):
        paired = np.int32(entry[d] + np.int32(cost[d]))
        after[d] = min(paired, np.int32(before[d - 1] + occlusion))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _trace_back(cost, sums, occlusion, out):  # type: ignore[no-untyped-def]
    d = np.argmin(sums[len(out) - 1])
    for k in range(len(out) - 1):
        x = len(out) - 1 - k
        if d > 0 and sums[x, d] == sums[x - 1, d - 1] + occlusion:
            out[x] = np.nan
            d -= 1
            continue
        out[x] = d
        entered = sums[x, d] - cost[x, d]
        skipped = 0
        while sums[x - 1, d + skipped] + skipped * occlusion != entered:
            skipped += 1
        d += skipped
    out[0] = d
