"""One scan into the tracks: time, assignment, correction, who is gone and who is new."""

from __future__ import annotations

import numba
import numpy as np

from sjmc_planner.track_assignment import (
    CX,
    CY,
    FIRST,
    FREE,
    KNOWN,
    LEFT,
    RADIUS,
    SD,
    SECOND,
    assign,
    assign_late,
    is_left,
    take,
)
from sjmc_planner.track_filter import STANDS, WALKS, correct, mix, predict, start

NUMBER, SIZE, AGE, UNSEEN, HITS, SHAPE_A, SHAPE_B, SWAY = range(8)
NUM_INFO = 8
_STARTS_WALKING = 0.1  # how probable that is of somebody new
_IS_FREE, _IS_PARTLY_FREE, _IS_KNOWN, _IS_LEFT = 0.5, 0.2, 0.6, 0.5  # shares of its ends
_TOLD_FREE, _TOLD_PARTLY, _TOLD_KNOWN, _TOLD_NOTHING = (
    1.2,
    0.5,
    -0.8,
    -0.2,
)  # log odds in a tenth of a second
_TOLD_LEFT = 0.3
_NEW_UNSEEN_S = 0.25  # somebody new who is not seen for so long was nobody
_THROUGH_S = 0.35  # nor is somebody there whose place is seen through for so long
_ACROSS, _BEHIND = 0.2, 0.3  # what has to be free for that, m
_OWN_LEG = 0.5  # a leg this near to somebody is rather theirs, m
_LATELY_S = 0.25
_SD_LATE = 0.1  # of whoever was farther on than expected, m
_SIZE_TAKEN = 0.3  # of a new width into the old one
_SWAYS, _SWAY_TAKEN = 0.1, 0.2  # m, of somebody new; share of a new one into the old
_STEP, _STEP_SWAYS = 0.05, 5.0  # m, times the sway: who stood and is so far off steps out
_LEAST_S = 0.05
_STEP_SD = 0.0625  # of a place: a body within 2 m; what is seen less well tells no steps
_STEP_P, _STEP_SD_V = 0.9, 0.4  # then it walks with this probability; deviation of its velocity


@numba.njit(cache=True, nogil=True)
def age_tracks(means, covs, p_walks, info, num, accel, dt):  # type: ignore[no-untyped-def]
    """Let time pass for all tracks."""
    for t in range(num):
        p_walks[t] = predict(means[t], covs[t], p_walks[t], accel, dt)
        info[t, AGE] += dt
        info[t, UNSEEN] += dt


@numba.njit(cache=True, nogil=True)
def see(  # type: ignore[no-untyped-def]
    means, covs, p_walks, info, num, candidates, num_candidates, num_shapes, since, least_radius
):
    """Take what a scan shows into the tracks that it fits; return which shapes are taken, (N,).

    Args:
        means: Of the tracks, shape (T, 2, 4).
        covs: Of the tracks, shape (T, 2, 4, 4).
        p_walks: Of the tracks, shape (T,).
        info: Columns as above, shape (T, NUM_INFO).
        num: How many tracks.
        candidates: From `candidates_of`.
        num_candidates: How many.
        num_shapes: How many shapes they are made of.
        since: Time since the last scan, s.
        least_radius: Of anybody, m.
    """
    taken = np.zeros(num_shapes, dtype=np.bool_)
    chosen = np.empty(num, dtype=np.int64)
    assign(candidates, num_candidates, means, covs, p_walks, num, taken, chosen)
    is_late = assign_late(candidates, num_candidates, means, p_walks, num, taken, chosen)
    for t in range(num):
        info[t, SHAPE_A] = info[t, SHAPE_B] = -1.0
        if chosen[t] < 0:
            continue
        c = candidates[chosen[t]]
        told = _told(c[FREE], c[KNOWN], c[LEFT]) * min(10.0 * since, 2.0)
        is_free = c[FREE] >= _IS_PARTLY_FREE or c[LEFT] >= _IS_LEFT
        variance = c[SD] ** 2 + (_SD_LATE**2 if is_late[t] else 0.0)
        steps_out = _steps_out(means[t, STANDS], p_walks[t], info[t], c, since)
        p_walks[t] = correct(means[t], covs[t], p_walks[t], c[CX], c[CY], variance, told, is_free)
        if steps_out:
            p_walks[t] = _set_out(means[t], covs[t], c, since)
        info[t, UNSEEN] = 0.0
        info[t, HITS] += 1.0
        info[t, SHAPE_A], info[t, SHAPE_B] = c[FIRST], c[SECOND]
        size = max(c[RADIUS], least_radius)
        info[t, SIZE] = max((1.0 - _SIZE_TAKEN) * info[t, SIZE] + _SIZE_TAKEN * size, least_radius)
    return taken


@numba.njit(cache=True, nogil=True)
def _steps_out(stands, p_walks, info, c, since):  # type: ignore[no-untyped-def]
    """Tell whether somebody who stood is off by far more than the sway so far; note the sway."""
    if p_walks > 0.5 or c[SD] > _STEP_SD or c[RADIUS] == 0.0 or since > 2.0 * _LATELY_S:
        info[SWAY] = _SWAYS
        return False
    off = np.hypot(c[CX] - stands[0], c[CY] - stands[1])
    if off > max(_STEP, _STEP_SWAYS * info[SWAY]):
        return True
    info[SWAY] += _SWAY_TAKEN * (off - info[SWAY])
    return False


@numba.njit(cache=True, nogil=True)
def _set_out(mean, cov, c, since):  # type: ignore[no-untyped-def]
    """Let a track walk from where it stood to where it is now, in place; return how surely."""
    stood = mean[STANDS, :2].copy()
    start(mean, cov, c[CX], c[CY], c[SD])
    for i in range(2):
        mean[WALKS, 2 + i] = (mean[WALKS, i] - stood[i]) / max(since, _LEAST_S)
    cov[WALKS, 2, 2] = cov[WALKS, 3, 3] = _STEP_SD_V**2
    return _STEP_P


@numba.njit(cache=True, nogil=True)
def _told(free, known, left):  # type: ignore[no-untyped-def]
    """Return what the space that something stands in tells of its moving: log odds."""
    if free >= _IS_FREE:
        return _TOLD_FREE
    if free >= _IS_PARTLY_FREE:
        return _TOLD_PARTLY
    if left >= _IS_LEFT:
        return _TOLD_LEFT  # something else may have stood there
    return _TOLD_KNOWN if known >= _IS_KNOWN else _TOLD_NOTHING


@numba.njit(cache=True, nogil=True)
def drop_gone(  # type: ignore[no-untyped-def]
    means, covs, p_walks, info, num, ranges, angle_min, increment, sensor, confirm, memory
):
    """Take out, in place, who has not been seen for too long; return how many are left."""
    left = 0
    for t in range(num):
        unseen = info[t, UNSEEN]
        allowed = memory if info[t, AGE] - unseen >= confirm else min(_NEW_UNSEEN_S, memory)
        if unseen > _THROUGH_S:
            x, y = mix(means[t], covs[t], p_walks[t])[0][:2]
            if _is_seen_through(x, y, ranges, angle_min, increment, sensor):
                allowed = min(allowed, _THROUGH_S)
        if unseen > allowed:
            continue
        if left < t:
            means[left], covs[left] = means[t], covs[t]
            p_walks[left], info[left] = p_walks[t], info[t]
        left += 1
    return left


@numba.njit(cache=True, nogil=True)
def _is_seen_through(x, y, ranges, angle_min, increment, sensor):  # type: ignore[no-untyped-def]
    """Tell whether the beams past a place all end behind it."""
    num = len(ranges)
    dx, dy = x - sensor[0], y - sensor[1]
    there = np.hypot(dx, dy)
    off = np.arctan2(dy, dx) - sensor[2] - angle_min
    off = off % (2.0 * np.pi) if increment > 0.0 else -((-off) % (2.0 * np.pi))
    beam = int(np.rint(off / increment))
    if beam >= num:
        return False
    reach = int(_ACROSS / max(there, _ACROSS) / abs(increment)) + 1
    for i in range(max(beam - reach, 0), min(beam + reach, num - 1) + 1):
        if not ranges[i] > there + _BEHIND:
            return False
    return True


@numba.njit(cache=True, nogil=True)
def _is_anothers(c, means, info, num):  # type: ignore[no-untyped-def]
    """Tell whether a single leg is so near to somebody that it is rather theirs."""
    for t in range(num):
        if info[t, UNSEEN] < _LATELY_S:
            off = np.hypot(c[CX] - means[t, WALKS, 0], c[CY] - means[t, WALKS, 1])
            if off < _OWN_LEG:
                return True
    return False


@numba.njit(cache=True, nogil=True)
def begin_new(  # type: ignore[no-untyped-def]
    means, covs, p_walks, info, num, candidates, num_candidates, taken, least_radius, last_number
):
    """Begin a track for each candidate that is left; return how many there are, and the number."""
    for k in range(num_candidates):
        c = candidates[k]
        if num == len(means) or not is_left(c, taken):
            continue
        take(c, taken)
        if c[RADIUS] == 0.0 and c[SECOND] < 0.0 and _is_anothers(c, means, info, num):
            continue
        start(means[num], covs[num], c[CX], c[CY], c[SD])
        p_walks[num] = _STARTS_WALKING
        last_number += 1
        info[num] = 0.0
        info[num, NUMBER], info[num, SIZE] = last_number, max(c[RADIUS], least_radius)
        info[num, SWAY] = _SWAYS
        info[num, HITS], info[num, SHAPE_A], info[num, SHAPE_B] = 1.0, c[FIRST], c[SECOND]
        num += 1
    return num, last_number
