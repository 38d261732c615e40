"""Which robots hide which: bodies stand in the line of sight."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def visibility(x: np.ndarray, cov: np.ndarray, radius: float, least: float) -> np.ndarray:
    """Return the chance that no body stands between two robots, (N, N), symmetric.

    Args:
        x: Poses, (N, 3).
        cov: Their covariance, (3 N, 3 N).
        radius: Of a body, m.
        least: What remains of the chance however well the poses are known.
    """
    n = len(x)
    chance = np.ones((n, n))
    spread = np.empty(n)
    for i in range(n):
        spread[i] = 0.5 * (cov[3 * i, 3 * i] + cov[3 * i + 1, 3 * i + 1])
    most = np.max(spread)
    for i in range(n):
        for j in range(i + 1, n):
            widest = radius + 3.0 * np.sqrt(most + max(spread[i], spread[j]))
            chance[i, j] = max(_clear_way(x, spread, i, j, radius, widest), least)
            chance[j, i] = chance[i, j]
    return chance


@numba.njit(cache=True)
def _clear_way(
    x: np.ndarray, spread: np.ndarray, i: int, j: int, radius: float, widest: float
) -> float:
    """Return the chance that nobody within `widest` of the line from i to j stands on it."""
    chance = 1.0
    dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
    squared = max(dx * dx + dy * dy, 1e-9)
    length, inverse = np.sqrt(squared), 1.0 / squared
    for k in range(len(x)):
        ex, ey = x[k, 0] - x[i, 0], x[k, 1] - x[i, 1]
        along = (ex * dx + ey * dy) * inverse
        across = ex * dy - ey * dx
        is_aside = across * across * inverse > widest * widest
        if along <= 0.0 or along >= 1.0 or is_aside or k in (i, j):
            continue
        beside = abs(across) / length
        sd = np.sqrt(spread[k] + along**2 * spread[j] + (1.0 - along) ** 2 * spread[i])
        far = (beside - radius) / max(sd, 1e-3)
        if far < 3.0:
            chance *= 1.0 / (1.0 + np.exp(-1.7 * far))
    return chance
