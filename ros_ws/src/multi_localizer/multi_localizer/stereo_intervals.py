"""One-sided interval-segmented DP matching (stereo paper, section 2).

The rows of the left image alone are cut into intervals where color changes, so that no interval
should lie on two surfaces. Each is matched to the right row by DP on its own, stretched or
shrunk by at most one pixel a column; two intervals may so stand in the other order in the right
image. An interval whose DP score is bad, or worse than that of others that want the same right
pixels, is hidden from the right camera and goes on as the interval before it (its left neighbor):
what a nearer object hides from the right camera lies to its left.

The paper's rule for cutting is in its reference 3, which the text does not contain; its title says
regions. Here a cut lies at every local maximum above a threshold of the color gradient along the
row, in an image whose texture a median has taken away and left the edges (the caller's).
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, error_model="numpy", nogil=True)
def cut_row(colors, threshold, ends):  # type: ignore[no-untyped-def]
    """Fill in the column after the last one of each interval of a row; return how many there are.

    Args:
        colors: (W, C), uint8.
        threshold: Least change from a column to the next, of the channel that changes most.
        ends: (W,), int32.
    """
    width = len(colors)
    num, before, here = 0, 0, 0
    for x in range(1, width + 1):
        after = _change(colors, x) if x < width else 0  # `here` is the change into column x - 1
        if here >= threshold and here >= before and here > after:
            ends[num] = x - 1
            num += 1
        before, here = here, after
    ends[num] = width
    return num + 1


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _change(colors: np.ndarray, x: int) -> int:
    change = 0
    for c in range(colors.shape[1]):
        change = max(change, int(abs(np.int64(colors[x, c]) - np.int64(colors[x - 1, c]))))
    return change


@numba.njit(cache=True, error_model="numpy", nogil=True)
def match_intervals(  # type: ignore[no-untyped-def]
    start, stop, costs, colors, threshold, stretch, worst, out, is_hidden
):
    """Fill in disparities of rows `start` to `stop`, and which pixels belong to hidden intervals.

    Args:
        start: First row.
        stop: Row after the last one.
        costs: (H, W, D), uint8.
        colors: Of the left image without its texture, (H, W, C), uint8.
        threshold: Of the cuts.
        stretch: Cost of a disparity that changes by 1 from one column to the next.
        worst: An interval is hidden if its score, the mean cost a column, is above this.
        out: (H, W), float32.
        is_hidden: (H, W), bool.
    """
    width, num = costs.shape[1], costs.shape[2]
    sums = np.empty((width, num), dtype=np.int32)
    ends = np.empty(width, dtype=np.int32)
    scores = np.empty(width, dtype=np.float64)
    owners = np.empty(width, dtype=np.int32)
    for y in range(start, stop):
        first = 0
        count = cut_row(colors[y], threshold, ends)
        for k in range(count):
            end = int(ends[k])
            score = match_interval(first, end, costs[y], stretch, sums, out[y])
            scores[k] = score / (end - first)
            first = end
        find_hidden(out[y], ends[:count], scores, worst, owners, is_hidden[y])
        go_on(out[y], is_hidden[y])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def match_interval(first, end, costs, stretch, sums, out):  # type: ignore[no-untyped-def]
    """Fill in disparities of columns `first` to `end` of a row; return what the best path matches.

    That is the sum of its costs without the stretching: a wall seen at a steep angle matches well.
    """
    for d in range(costs.shape[1]):
        sums[first, d] = costs[first, d]
    for x in range(first + 1, end):
        _extend(costs[x], sums[x - 1], stretch, sums[x])
    d = int(np.argmin(sums[end - 1]))
    score = np.int64(0)
    for k in range(end - first - 1):
        x = end - 1 - k
        out[x] = d
        score += np.int64(costs[x, d])
        d += _step_back(sums[x - 1], d, stretch)
    out[first] = d
    return score + np.int64(costs[first, d])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def find_hidden(disparities, ends, scores, worst, owners, is_hidden):  # type: ignore[no-untyped-def]
    """Mark intervals hidden from the right camera, by their scores.

    They are those whose score is above `worst`, and those that lose more than half of their right
    pixels to intervals of better scores: one right pixel shows one surface.

    Args:
        disparities: Of a row, whole, (W,), float32.
        ends: Column after the last one of each interval, (N,).
        scores: Mean cost of each interval, (N,) at least.
        worst: See above.
        owners: Memory, (W,), int32.
        is_hidden: (W,), bool, filled in.
    """
    owners[:] = -1
    first = 0
    for k in range(len(ends)):
        for x in range(first, ends[k]):
            partner = x - int(disparities[x])
            owner = owners[partner] if partner >= 0 else -1
            if partner >= 0 and (owner < 0 or scores[k] < scores[owner]):
                owners[partner] = k
        first = ends[k]
    first = 0
    for k in range(len(ends)):
        lost = 0
        for x in range(first, ends[k]):
            partner = x - int(disparities[x])
            if partner < 0 or owners[partner] != k:
                lost += 1
        is_hidden[first : ends[k]] = scores[k] > worst or 2 * lost > ends[k] - first
        first = ends[k]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _extend(cost, before, stretch, after):  # type: ignore[no-untyped-def]
    last = len(after) - 1
    after[0] = cost[0] + min(before[0], before[min(1, last)] + stretch)
    for d in range(1, last):
        aside = np.int32(min(before[d - 1], before[d + 1]) + stretch)
        after[d] = np.int32(min(before[d], aside) + np.int32(cost[d]))
    after[last] = cost[last] + min(before[last], before[max(last - 1, 0)] + stretch)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _step_back(before, d, stretch):  # type: ignore[no-untyped-def]
    """Return how the disparity changed on the way to column x, seen from there."""
    best, step = before[d], 0
    if d > 0 and before[d - 1] + stretch < best:
        best, step = before[d - 1] + stretch, -1
    if d + 1 < len(before) and before[d + 1] + stretch < best:
        step = 1
    return step


@numba.njit(cache=True, error_model="numpy", nogil=True)
def go_on(disparities, is_hidden):  # type: ignore[no-untyped-def]
    """Let hidden intervals go on as what lies before them; those at a row's start as what follows.

    Args:
        disparities: Of a row, (W,), float32.
        is_hidden: (W,), bool.
    """
    known = np.float32(np.nan)
    for x in range(len(disparities)):
        if not is_hidden[x]:
            if np.isnan(known):
                disparities[:x] = disparities[x]
            known = disparities[x]
        else:
            disparities[x] = known
