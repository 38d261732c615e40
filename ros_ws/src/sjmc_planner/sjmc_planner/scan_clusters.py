"""The things that a scan shows: beams that belong together, from one edge to the next.

Two neighboring ends belong to different things if they are farther apart than noise and the beams'
spacing explain, and no straight surface runs through them: along a straight wall 1/r changes
evenly from beam to beam, however slanted it is, so a wall seen at a grazing angle stays in one
piece and a person before it does not.
"""

from __future__ import annotations

import numba
import numpy as np

_GAP = 0.08  # nearer ends are one thing, m
_GAP_SHARE = 0.01  # and for noise, of the range
_SPACING = 1.5  # and of the beams' distance from each other there
_EVEN = 2.0  # a step of 1/r beyond this times the next ones is an edge
_MISSING = 2  # lost beams that may lie between
_NOTCH = 0.08  # this much farther than what is beside it: two people side by side, m
_NOTCH_SHARE = 0.015  # and for noise, of the range


@numba.njit(cache=True, nogil=True)
def cluster_beams(  # type: ignore[no-untyped-def]
    ranges, range_min, range_max, step, widest, labels, ends
):
    """Label the beams of each thing; the labels count up along the scan.

    Args:
        ranges: Shape (N,), m.
        range_min: Shortest range that counts, m.
        range_max: Longest range that counts, m.
        step: Angle between beams, rad.
        widest: Things up to twice as wide are parted where a notch shows two people, m.
        labels: Output: the thing of each beam, -1 for none, shape (N,).
        ends: Output: first and last beam of each thing, and how many, shape (N, 3); of a full turn
            the last may be smaller.

    Returns:
        The number of things.
    """
    num = len(ranges)
    is_round = step * num > 2.0 * np.pi - 1e-6
    hits = np.empty(num, dtype=np.int64)
    num_hits = 0
    for i in range(num):
        labels[i] = -1
        r = ranges[i]
        if r >= range_min and r <= range_max and r > 0.0:
            hits[num_hits] = i
            num_hits += 1
    if num_hits == 0:
        return 0
    begin = 0  # of a full turn, the first beam behind an edge
    if is_round:
        while begin < num_hits and not _is_edge(ranges, hits, num_hits, begin, step, True):
            begin += 1
        if 0 < begin < num_hits:
            hits[:num_hits] = np.roll(hits[:num_hits], -begin)
    label, start = 0, 0
    for k in range(1, num_hits + 1):
        if k < num_hits and not _is_edge(ranges, hits, num_hits, k, step, is_round):
            continue
        label = _part(ranges, hits, start, k, step, widest, label, labels, ends)
        start = k
    return label


@numba.njit(cache=True, nogil=True)
def _part(  # type: ignore[no-untyped-def]
    ranges, hits, start, end, step, widest, label, labels, ends
):
    """Label one thing, in two if it is as wide as two people and has a notch; return the next."""
    a, b = hits[start], hits[end - 1]
    angle = ((b - a) % len(ranges)) * step
    ra, rb = ranges[a], ranges[b]
    width2 = (ra - rb) ** 2 + 4.0 * ra * rb * np.sin(0.5 * min(angle, np.pi)) ** 2
    cut = -1
    if 0.25 * widest * widest < width2 < 4.0 * widest * widest:
        cut = _notch(ranges, hits, start, end)
    begin = start
    for k in range(start, end):
        if k == cut:  # it may be either's
            label, begin = label + 1, k + 1
            continue
        labels[hits[k]] = label
        ends[label, 0], ends[label, 1], ends[label, 2] = hits[begin], hits[k], k - begin + 1
    return label + 1


@numba.njit(cache=True, nogil=True)
def _notch(ranges, hits, start, end):  # type: ignore[no-untyped-def]
    """Return the hit that is farthest behind the nearest ones on both sides of it, or -1."""
    after = np.empty(end - start)
    nearest = np.inf
    for k in range(end - 1, start - 1, -1):
        nearest = min(nearest, ranges[hits[k]])
        after[k - start] = nearest
    before, best, cut = np.inf, 0.0, -1
    for k in range(start + 2, end - 2):
        before = min(before, ranges[hits[k - 1]])
        r = ranges[hits[k]]
        depth = r - max(before, after[k + 1 - start]) - _NOTCH - _NOTCH_SHARE * r
        if depth > best:
            best, cut = depth, k
    return cut


@numba.njit(cache=True, nogil=True)
def _is_edge(ranges, hits, num_hits, k, step, is_round):  # type: ignore[no-untyped-def]
    """Tell whether hit k begins another thing than the hit before it."""
    num = len(ranges)
    a, b = hits[k - 1] if k > 0 else hits[num_hits - 1], hits[k]
    apart = b - a if b > a else b - a + num
    if apart > _MISSING + 1:
        return True
    ra, rb = ranges[a], ranges[b]
    near, angle = min(ra, rb), apart * step
    distance2 = (rb - ra) ** 2 + ra * rb * angle * angle
    allowed = _GAP + _GAP_SHARE * near + _SPACING * near * angle
    if distance2 < allowed * allowed:
        return False
    change = abs(1.0 / rb - 1.0 / ra) / apart
    for other in (k - 1, k + 1):  # the steps before and after
        if (other < 1 or other >= num_hits) and not is_round:
            continue
        c, d = hits[(other - 1) % num_hits], hits[other % num_hits]
        between = (d - c) % num
        if 0 < between <= _MISSING + 1:
            even = abs(1.0 / ranges[d] - 1.0 / ranges[c]) / between
            if change < _EVEN * even:
                return False
    return True
