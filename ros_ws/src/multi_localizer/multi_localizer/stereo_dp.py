"""Monotone continuous DP along whole rows: what the paper holds its own method against (section 2).

The path of DP matching through (column of the left row, column of the right row): every step leads
to the next column of one row or of both, so that each left pixel has a partner, the order never
reverses and nothing is left out; a step that is not to both costs `step` more. Where a nearer
surface hides what lies to its left, its edge is so drawn out over the hidden pixels.
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, error_model="numpy", nogil=True)
def match_monotone(start, stop, costs, step, out):  # type: ignore[no-untyped-def]
    """Fill in whole disparities of rows `start` to `stop`.

    Args:
        start: First row.
        stop: Row after the last one.
        costs: (H, W, D), uint8.
        step: Price of a step along one row alone.
        out: (H, W), float32.
    """
    width, num = costs.shape[1], costs.shape[2]
    sums = np.empty((width, num), dtype=np.int32)
    entry = np.empty(num, dtype=np.int32)
    for y in range(start, stop):
        for d in range(num):
            sums[0, d] = costs[y, 0, d]
        for x in range(1, width):
            _enter(sums[x - 1], step, entry)
            _extend(costs[y, x], entry, sums[x])
        _trace_back(costs[y], sums, step, out[y])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _enter(before, step, entry):  # type: ignore[no-untyped-def]
    """Fill in the least sum with which each disparity is reached from the column before.

    The disparity grows by 1 where the left row alone goes on, and falls by 1 with every step of the
    right row alone.
    """
    last = len(before) - 1
    best = before[last]
    entry[last] = best
    for k in range(last):
        d = last - 1 - k
        best = min(before[d], np.int32(best + step))
        entry[d] = best
    for k in range(last):
        d = last - k
        entry[d] = min(entry[d], np.int32(before[d - 1] + step))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _extend(cost, entry, after):  # type: ignore[no-untyped-def]
    for d in range(len(after)):
        after[d] = np.int32(entry[d] + np.int32(cost[d]))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _trace_back(cost, sums, step, out):  # type: ignore[no-untyped-def]
    d = int(np.argmin(sums[len(out) - 1]))
    for k in range(len(out) - 1):
        x = len(out) - 1 - k
        out[x] = d
        entered = sums[x, d] - cost[x, d]
        if d > 0 and sums[x - 1, d - 1] + step == entered:
            d -= 1
            continue
        skipped = 0
        while sums[x - 1, d + skipped] + skipped * step != entered:
            skipped += 1
        d += skipped
    out[0] = d
