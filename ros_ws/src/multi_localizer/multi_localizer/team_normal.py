"""Residuals of a team's bearings and rough poses, and their normal equations.

Poses x are rows (x, y, yaw). With d = p_j - p_i, r = |d| and phi the direction of d, the residual
of robot i's bearing b to robot j is

    e = b + yaw_i - phi,   de/dp_i = (-d_y, d_x) / r^2,   de/dp_j = -de/dp_i,   de/dyaw_i = 1.

Every row has five entries that are not zero, so the blocks are added where they belong.
"""

from __future__ import annotations

import numba
import numpy as np

_NEAREST = 1e-6  # m^2; two robots in one place have no direction


@numba.njit(cache=True, inline="always")
def wrap(angle: float) -> float:
    """Return the angle in [-pi, pi) that points the same way."""
    return angle - 2.0 * np.pi * np.floor(angle / (2.0 * np.pi) + 0.5)


@numba.njit(cache=True, inline="always")
def bearing_residual(
    x: float, y: float, yaw: float, to_x: float, to_y: float, bearing: float
) -> tuple[float, float, float]:
    """Return the residual of a bearing and its derivative by the observer's x and y."""
    dx, dy = to_x - x, to_y - y
    squared = max(dx * dx + dy * dy, _NEAREST)
    return wrap(bearing + yaw - np.arctan2(dy, dx)), -dy / squared, dx / squared


@numba.njit(cache=True, inline="always")
def robust_weight(squared: float, limit: float) -> float:
    """Return how much a residual counts: all within `limit` deviations, less and less beyond."""
    return 1.0 if squared <= limit * limit else (limit * limit / squared) ** 2


@numba.njit(cache=True, inline="always")
def robust_cost(squared: float, limit: float) -> float:
    """Return the cost whose derivative by the squared residual is `robust_weight`."""
    top = limit * limit
    return squared if squared <= top else 2.0 * top - top * top / squared


@numba.njit(cache=True)
def add_bearing(
    H: np.ndarray, g: np.ndarray, x: np.ndarray, i: int, j: int,
    bearing: float, weight: float, var: float, limit: float,
) -> float:  # fmt: skip
    """Add robot i's bearing to robot j to the normal equations H dx = -g; return its cost."""
    e, a, b = bearing_residual(x[i, 0], x[i, 1], x[i, 2], x[j, 0], x[j, 1], bearing)
    squared = e * e / var
    w = weight * robust_weight(squared, limit) / var
    p, q = 3 * i, 3 * j
    aa, ab, bb = w * a * a, w * a * b, w * b * b
    H[p, p] += aa
    H[p + 1, p + 1] += bb
    H[p + 1, p] += ab
    H[p + 2, p] += w * a
    H[p + 2, p + 1] += w * b
    H[p + 2, p + 2] += w
    H[q, q] += aa
    H[q + 1, q + 1] += bb
    H[q + 1, q] += ab
    high, low = max(p, q), min(p, q)
    H[high, low] -= aa
    H[high, low + 1] -= ab
    H[high + 1, low] -= ab
    H[high + 1, low + 1] -= bb
    if q > p:
        H[q, p + 2] -= w * a
        H[q + 1, p + 2] -= w * b
    else:
        H[p + 2, q] -= w * a
        H[p + 2, q + 1] -= w * b
    g[p] += w * a * e
    g[p + 1] += w * b * e
    g[p + 2] += w * e
    g[q] -= w * a * e
    g[q + 1] -= w * b * e
    return weight * robust_cost(squared, limit)


@numba.njit(cache=True)
def add_mark(
    H: np.ndarray, g: np.ndarray, x: np.ndarray, i: int, mark: np.ndarray,
    bearing: float, weight: float, var: float, limit: float,
) -> float:  # fmt: skip
    """Add robot i's bearing to a landmark at `mark`; return its cost."""
    e, a, b = bearing_residual(x[i, 0], x[i, 1], x[i, 2], mark[0], mark[1], bearing)
    squared = e * e / var
    w = weight * robust_weight(squared, limit) / var
    p = 3 * i
    H[p, p] += w * a * a
    H[p + 1, p] += w * a * b
    H[p + 1, p + 1] += w * b * b
    H[p + 2, p] += w * a
    H[p + 2, p + 1] += w * b
    H[p + 2, p + 2] += w
    g[p] += w * a * e
    g[p + 1] += w * b * e
    g[p + 2] += w * e
    return weight * robust_cost(squared, limit)


@numba.njit(cache=True)
def add_prior(
    H: np.ndarray, g: np.ndarray, x: np.ndarray, i: int, prior: np.ndarray, info: np.ndarray,
    weight: float, limit: float,
) -> float:  # fmt: skip
    """Add robot i's rough pose with its inverse covariance `info`; return its cost."""
    e = np.empty(3)
    e[0], e[1] = x[i, 0] - prior[0], x[i, 1] - prior[1]
    e[2] = wrap(x[i, 2] - prior[2])
    squared = 0.0
    for r in range(3):
        for c in range(3):
            squared += e[r] * info[r, c] * e[c]
    counts = weight * robust_weight(squared / 3.0, limit)
    for r in range(3):
        for c in range(3):
            if c <= r:
                H[3 * i + r, 3 * i + c] += counts * info[r, c]
            g[3 * i + r] += counts * info[r, c] * e[c]
    return weight * 3.0 * robust_cost(squared / 3.0, limit)
