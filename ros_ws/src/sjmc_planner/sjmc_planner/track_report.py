"""The tracks as the robot has them around it: from the frame that stands still to its own."""

from __future__ import annotations

import numba
import numpy as np

from sjmc_planner.track_filter import mix
from sjmc_planner.track_update import AGE, SHAPE_A, SHAPE_B, UNSEEN


@numba.njit(cache=True, nogil=True)
def report(  # type: ignore[no-untyped-def]
    means, covs, p_walks, info, num, base, confirm, things, labels, states, covs_base, beam_track
):
    """Write the tracks that have been seen for long enough; return which they are, shape (M,).

    Args:
        means: Of the tracks, shape (T, 2, 4).
        covs: Of the tracks, shape (T, 2, 4, 4).
        p_walks: Of the tracks, shape (T,).
        info: From `track_update`.
        num: How many tracks.
        base: x, y, yaw of the robot.
        confirm: For how long, s.
        things: Which thing each shape is, shape (S,).
        labels: Which thing each beam met, shape (N,).
        states: Output: x, y, vx, vy in the base frame, shape (T, 4).
        covs_base: Output: their covariances, shape (T, 4, 4).
        beam_track: Output: which row of the result each beam met, -1 for none, shape (N,).
    """
    shown = np.empty(num, dtype=np.int64)
    thing_track = np.full(len(labels) + 1, -1)
    c, s = np.cos(base[2]), np.sin(base[2])
    rows = 0
    for t in range(num):
        if info[t, AGE] - info[t, UNSEEN] < confirm - 1e-9:
            continue
        mean, cov = mix(means[t], covs[t], p_walks[t])
        mean[0] -= base[0]
        mean[1] -= base[1]
        _turn(mean, cov, c, s, states[rows], covs_base[rows])
        for column in (SHAPE_A, SHAPE_B):
            shape = int(info[t, column])
            if info[t, UNSEEN] == 0.0 and shape >= 0:
                thing_track[things[shape]] = rows
        shown[rows] = t
        rows += 1
    for i in range(len(labels)):
        beam_track[i] = thing_track[labels[i]] if labels[i] >= 0 else -1
    return shown[:rows]


@numba.njit(cache=True, nogil=True)
def _turn(mean, cov, c, s, turned, cov_turned):  # type: ignore[no-untyped-def]
    """Write a state and its covariance seen from a frame that is turned by the angle of c, s."""
    for i in (0, 2):
        turned[i] = c * mean[i] + s * mean[i + 1]
        turned[i + 1] = c * mean[i + 1] - s * mean[i]
        for j in (0, 2):
            xx, xy = cov[i, j], cov[i, j + 1]
            yx, yy = cov[i + 1, j], cov[i + 1, j + 1]
            a, b = c * xx + s * yx, c * xy + s * yy
            d, e = c * yx - s * xx, c * yy - s * xy
            cov_turned[i, j], cov_turned[i, j + 1] = c * a + s * b, c * b - s * a
            cov_turned[i + 1, j], cov_turned[i + 1, j + 1] = c * d + s * e, c * e - s * d
