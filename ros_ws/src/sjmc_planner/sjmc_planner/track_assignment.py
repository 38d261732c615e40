"""Which thing of a scan is which person: bodies, or legs alone and in pairs.

Everything that may be a person is a candidate: each thing as wide as a body, each leg, and each two
legs no farther apart than a step. Tracks take candidates in the order of how well they fit (greedy,
by Mahalanobis distance and the logarithm of the spread); nothing is taken twice. What is left may
be new: bodies, then pairs of legs, nearest first, then single legs.
"""

from __future__ import annotations

import numba
import numpy as np

from sjmc_planner.scan_shapes import BEAMS, HALF, HIDDEN, RANGE, WIDTH, X, Y
from sjmc_planner.track_filter import distance2

FIRST, SECOND, CX, CY, SD, RADIUS, FREE, KNOWN, LEFT = range(9)
NUM_CANDIDATE_COLUMNS = 9
_GATE2 = 11.8  # chi^2 of two dimensions, 99.7 %
_REACH = 1.5  # no candidate farther from where it is expected is looked at, m
_SD_BODY, _SD_HIDDEN, _SD_PAIR, _SD_LEG = 0.05, 0.12, 0.06, 0.22
_SD_SHARE = 0.006  # of the range
_LEG_PENALTY = 3.0
_LATE, _LATE_WALKS = 0.5, 0.4  # how far off a walker may still be, m, and how surely it walks
_STEP_M, _STEP_FREE = 0.3, 0.5  # how far off who stood, m, and how much of it where all was free


@numba.njit(cache=True, nogil=True)
def candidates_of(  # type: ignore[no-untyped-def]
    shapes, num_shapes, told, leg_width, step, candidates
):
    """Write all candidates: bodies, pairs of legs by distance, legs; return how many.

    Args:
        shapes: From `scan_shapes`.
        num_shapes: How many of them.
        told: Which share of each is free, known and left (`seen_free`), shape (N, 3).
        leg_width: What is no wider is a leg, m.
        step: Legs of a pair are no farther apart, m.
        candidates: Output: rows of the columns above.
    """
    num, most = 0, len(candidates)
    legs = np.empty(num_shapes, dtype=np.int64)
    num_legs = 0
    for i in range(num_shapes):
        if shapes[i, WIDTH] <= leg_width:
            legs[num_legs] = i
            num_legs += 1
        elif num < most:
            sd = _SD_HIDDEN if shapes[i, HIDDEN] else _SD_BODY
            _write(candidates[num], shapes, told, i, -1, sd, shapes[i, HALF])
            num += 1
    begin = num
    for n in range(num_legs):
        for m in range(n):
            i, j = legs[n], legs[m]
            apart = np.hypot(shapes[i, X] - shapes[j, X], shapes[i, Y] - shapes[j, Y])
            if apart <= step and num < most:
                _write(candidates[num], shapes, told, j, i, _SD_PAIR, apart)
                num += 1
    order = np.argsort(candidates[begin:num, RADIUS])
    candidates[begin:num] = candidates[begin:num][order]
    for n in range(num_legs):
        if num < most:
            _write(candidates[num], shapes, told, legs[n], -1, _SD_LEG, shapes[legs[n], HALF])
            num += 1
    for k in range(begin, num):
        candidates[k, RADIUS] = 0.0  # legs do not tell how wide a body is
    return num


@numba.njit(cache=True, nogil=True)
def _write(row, shapes, told, i, j, sd, radius):  # type: ignore[no-untyped-def]
    row[FIRST], row[SECOND] = i, j
    other = i if j < 0 else j
    row[CX] = 0.5 * (shapes[i, X] + shapes[other, X])
    row[CY] = 0.5 * (shapes[i, Y] + shapes[other, Y])
    row[SD] = sd + _SD_SHARE * 0.5 * (shapes[i, RANGE] + shapes[other, RANGE])
    row[RADIUS] = radius
    share = shapes[i, BEAMS] / (shapes[i, BEAMS] + shapes[other, BEAMS])
    row[FREE] = share * told[i, 0] + (1.0 - share) * told[other, 0]
    row[KNOWN] = share * told[i, 1] + (1.0 - share) * told[other, 1]
    row[LEFT] = share * told[i, 2] + (1.0 - share) * told[other, 2]


@numba.njit(cache=True, nogil=True)
def assign(  # type: ignore[no-untyped-def]
    candidates, num, means, covs, p_walks, num_tracks, taken, chosen
):
    """Write the candidate of each track, -1 for none.

    Args:
        candidates: From `candidates_of`.
        num: How many.
        means: Of the tracks, shape (T, 2, 4).
        covs: Of the tracks, shape (T, 2, 4, 4).
        p_walks: Of the tracks, shape (T,).
        num_tracks: How many.
        taken: Output: which shapes are taken, shape (N,).
        chosen: Output: shape (T,).
    """
    most = 16 * num_tracks
    costs = np.empty(most)
    pairs = np.empty((most, 2), dtype=np.int64)
    count = 0
    for t in range(num_tracks):
        chosen[t] = -1
        for c in range(num):
            x, y = candidates[c, CX], candidates[c, CY]
            if abs(x - means[t, 1, 0]) > _REACH or abs(y - means[t, 1, 1]) > _REACH:
                continue
            cost = _cost(candidates[c], means[t], covs[t], p_walks[t])
            if cost < np.inf and count < most:
                costs[count], pairs[count, 0], pairs[count, 1] = cost, t, c
                count += 1
    for k in np.argsort(costs[:count]):
        t, c = pairs[k]
        if chosen[t] < 0 and is_left(candidates[c], taken):
            chosen[t] = c
            take(candidates[c], taken)


@numba.njit(cache=True, nogil=True)
def assign_late(candidates, num, means, p_walks, num_tracks, taken, chosen):  # type: ignore[no-untyped-def]
    """Give tracks without a candidate the nearest one that is left; return which got one, (T,).

    One leg alone says little of the middle: when the other comes into view again, the person may
    be farther on than the filter thinks possible, and is still the same. And who stood and steps
    out at a walker's speed leaves the place within a scan: a body next to it where all was free.
    """
    is_late = np.zeros(num_tracks, dtype=np.bool_)
    for _ in range(num_tracks):
        best, track, candidate = _LATE, -1, -1
        for t in range(num_tracks):
            if chosen[t] >= 0:
                continue
            stood = p_walks[t] < _LATE_WALKS
            for c in range(num):
                if stood and (candidates[c, RADIUS] == 0.0 or candidates[c, FREE] < _STEP_FREE):
                    continue
                off = np.hypot(
                    candidates[c, CX] - means[t, 1, 0], candidates[c, CY] - means[t, 1, 1]
                )
                if off < min(best, _STEP_M if stood else best) and is_left(candidates[c], taken):
                    best, track, candidate = off, t, c
        if track < 0:
            break
        chosen[track] = candidate
        is_late[track] = True
        take(candidates[candidate], taken)
    return is_late


@numba.njit(cache=True, nogil=True)
def _cost(candidate, mean, cov, p_walks):  # type: ignore[no-untyped-def]
    """Return how badly a candidate fits a track; inf if it does not."""
    best = np.inf
    variance = candidate[SD] ** 2
    for m in range(2):
        p = p_walks if m == 1 else 1.0 - p_walks
        if p < 0.05:
            continue
        d2, log_det = distance2(mean[m], cov[m], candidate[CX], candidate[CY], variance)
        if d2 < _GATE2:
            best = min(best, d2 + log_det - 2.0 * np.log(p))
    is_single = candidate[SECOND] < 0 and candidate[RADIUS] == 0.0
    return best + (_LEG_PENALTY if is_single else 0.0)


@numba.njit(cache=True, nogil=True)
def is_left(candidate, taken):  # type: ignore[no-untyped-def]
    """Tell whether nothing of a candidate is taken."""
    i, j = int(candidate[FIRST]), int(candidate[SECOND])
    return not taken[i] and (j < 0 or not taken[j])


@numba.njit(cache=True, nogil=True)
def take(candidate, taken):  # type: ignore[no-untyped-def]
    """Mark what a candidate consists of as taken."""
    taken[int(candidate[FIRST])] = True
    if candidate[SECOND] >= 0.0:
        taken[int(candidate[SECOND])] = True
