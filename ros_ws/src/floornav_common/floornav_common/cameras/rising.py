"""The inverse of a rising function, for whole arrays at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_MAX_STEPS = 60
_TOL = 1e-15

Function = Callable[[np.ndarray], np.ndarray]


def solve_rising(
    function: Function, slope: Function, target: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Return where a rising function takes values, by Newton's method kept within brackets.

    Args:
        function: Rises from `low` to `high`.
        slope: Its derivative.
        target: The values, any shape; NaN gives NaN.
        low: Where the function is not above the target, of the target's shape.
        high: Where it is not below.
    """
    target = np.asarray(target, dtype=float)
    low, high = np.broadcast_to(low, target.shape), np.broadcast_to(high, target.shape)
    x = np.where(np.isnan(target), np.nan, 0.5 * (low + high))
    for _ in range(_MAX_STEPS):
        off = function(x) - target
        low, high = np.where(off <= 0.0, x, low), np.where(off >= 0.0, x, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = x - off / slope(x)
            is_in = (step >= low) & (step <= high)
        after = np.where(is_in, step, 0.5 * (low + high))
        after = np.where(np.isnan(target), np.nan, after)
        with np.errstate(invalid="ignore"):
            is_moving = np.abs(after - x) > _TOL * np.maximum(1.0, np.abs(x))
        x = after
        if not is_moving.any():
            break
    return np.asarray(x)
