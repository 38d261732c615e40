"""Which thing a bearing without a name belongs to, told by geometry alone."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

_NEVER = -1e6


def tell_apart(log_fits: np.ndarray, log_nothing: float, odds: float) -> np.ndarray:
    """Return what each bearing of one moment belongs to, where that can be told.

    The most likely way to give every bearing a thing of its own, or nothing, is found; a part of it
    is believed if the best way without that part is less likely than one to `odds`.

    Args:
        log_fits: Log density of each bearing (row) if it belongs to a thing (column), shape (M, N);
            -inf where it cannot.
        log_nothing: Log density of a bearing that belongs to none of them.
        odds: How many times as likely as its rivals the answer must be.

    Returns:
        Column of each bearing, -1 where it is nothing's or cannot be told; shape (M,), int.
    """
    num_bearings, num_things = log_fits.shape
    chosen = np.full(num_bearings, -1)
    if num_bearings == 0 or num_things == 0:
        return chosen
    scores = np.full((num_bearings, num_things + num_bearings), _NEVER)
    scores[:, :num_things] = np.maximum(log_fits, _NEVER)
    scores[:, num_things:][np.diag_indices(num_bearings)] = log_nothing
    best, columns = _best(scores)
    for row, column in enumerate(columns):
        if column >= num_things:
            continue
        without = scores.copy()
        without[row, column] = _NEVER
        if best - _best(without)[0] >= np.log(odds):
            chosen[row] = column
    return chosen


def _best(scores: np.ndarray) -> tuple[float, np.ndarray]:
    rows, columns = linear_sum_assignment(scores, maximize=True)
    return float(scores[rows, columns].sum()), columns
