"""Headings that are only loosely known, from the pattern of all bearings of a robot.

All bearings of a robot share one unknown turn. Over turns within reach the pattern is compared
with where the rough positions say the teammates are: each teammate is at one of the bearings, or
hidden. The best turn's neighborhood gives its value and deviation. This only starts the search.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap

_REACH = 3.0  # deviations
_STEP = 0.035  # rad
_LEAST_SD = 0.07  # rad; the others' positions are not told again
_WIDER = 1.5
_DETECTED = 0.8
CLUTTER = 0.5 / (2.0 * np.pi)  # half a bearing of nobody's, anywhere around


@numba.njit(cache=True)
def settle_yaws(
    x: np.ndarray, cov: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    from_sd: float, far_sd: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return poses and covariance with the yaws of loosely known ones settled.

    Args:
        x: Poses, (N, 3).
        cov: Their covariance, (3 N, 3 N).
        start: Where each robot's bearings begin, (N + 1,).
        bearings: (M,), rad.
        var: Their variances, (M,).
        from_sd: A yaw known better than this stays, rad.
        far_sd: A robot whose position is known worse than this takes no part, m.
    """
    n = len(x)
    result, result_cov = x.copy(), cov.copy()
    for i in range(n):
        sd = np.sqrt(cov[3 * i + 2, 3 * i + 2])
        if sd < from_sd or position_sd(cov, i) > far_sd or start[i + 1] - start[i] < 2:
            continue
        turn, spread = _best_turn(x, cov, start, bearings, var, i, min(sd, 1.1), far_sd)
        spread = max(_WIDER * spread, _LEAST_SD)
        if spread < sd:
            result[i, 2] = wrap(x[i, 2] + turn)
            shrink = spread / sd
            for k in range(3 * n):
                result_cov[3 * i + 2, k] *= shrink
                result_cov[k, 3 * i + 2] *= shrink
    return result, result_cov


@numba.njit(cache=True)
def position_sd(cov: np.ndarray, i: int) -> float:
    """Return the deviation of robot i's position along one axis, the mean of both, m."""
    return np.sqrt(0.5 * (cov[3 * i, 3 * i] + cov[3 * i + 1, 3 * i + 1]))


@numba.njit(cache=True)
def _best_turn(
    x: np.ndarray, cov: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    i: int, sd: float, far_sd: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the mean turn of robot i and its deviation, weighted by how well each turn fits."""
    half = int(np.ceil(_REACH * sd / _STEP))
    scores = np.empty(2 * half + 1)
    for s in range(len(scores)):
        turn = (s - half) * _STEP
        scores[s] = -0.5 * (turn / sd) ** 2
    for j in range(len(x)):
        if j == i or position_sd(cov, j) > far_sd:
            continue
        dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
        squared = max(dx * dx + dy * dy, 1e-2)
        spread = (position_sd(cov, i) ** 2 + position_sd(cov, j) ** 2) / squared
        v = min(spread + spread * spread, 3.0) + var[start[i]]
        expected = np.arctan2(dy, dx) - x[i, 2]
        for s in range(len(scores)):
            turn = (s - half) * _STEP
            total = 0.0
            for k in range(start[i], start[i + 1]):
                e = wrap(bearings[k] + turn - expected)
                if e * e < 12.0 * v:
                    total += np.exp(-0.5 * e * e / v)
            total *= _DETECTED / np.sqrt(2.0 * np.pi * v) / CLUTTER
            scores[s] += np.log(1.0 - _DETECTED + total)
    return _mean_turn(scores, half)


@numba.njit(cache=True)
def _mean_turn(scores: np.ndarray, half: int) -> tuple[float, float]:
    """Return the mean turn and its deviation under log-likelihoods of turns around `half`."""
    best = np.max(scores)
    weights, mean, square = 0.0, 0.0, 0.0
    for s in range(len(scores)):
        w, turn = np.exp(scores[s] - best), (s - half) * _STEP
        weights += w
        mean += w * turn
        square += w * turn * turn
    mean /= weights
    return mean, np.sqrt(max(square / weights - mean * mean, 0.0))
