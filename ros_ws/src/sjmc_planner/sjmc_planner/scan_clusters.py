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


@numba.njit(cache=True, nogil=True)
def cluster_beams(ranges, range_min, range_max, step, labels):  # type: ignore[no-untyped-def]
    """Label the beams of each thing; the labels count up along the scan.

    Args:
        ranges: Shape (N,), m.
        range_min: Shortest range that counts, m.
        range_max: Longest range that counts, m.
        step: Angle between beams, rad.
        labels: Output: the thing of each beam, -1 for none, shape (N,).

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
    label = 0
    labels[hits[0]] = 0
    for k in range(1, num_hits):
        if _is_edge(ranges, hits, num_hits, k, step, False):
            label += 1
        labels[hits[k]] = label
    if is_round and label > 0 and not _is_edge(ranges, hits, num_hits, 0, step, True):
        for k in range(num_hits - 1, -1, -1):  # the last thing goes on in the first
            if labels[hits[k]] != label:
                break
            labels[hits[k]] = 0
        label -= 1
    return label + 1


@numba.njit(cache=True, nogil=True)
def _is_edge(ranges, hits, num_hits, k, step, is_round):  # type: ignore[no-untyped-def]
    """Tell whether hit k begins another thing than the hit before it."""
    num = len(ranges)
    a, b = hits[k - 1] if k > 0 else hits[num_hits - 1], hits[k]
    apart = b - a if k > 0 else b - a + num
    if apart > _MISSING + 1:
        return True
    ra, rb = ranges[a], ranges[b]
    near = min(ra, rb)
    across = 2.0 * np.sin(0.5 * apart * step)
    distance2 = (rb - ra) ** 2 + ra * rb * across * across
    allowed = _GAP + _GAP_SHARE * near + _SPACING * near * apart * step
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
