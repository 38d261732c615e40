"""Who sees whom as a matter of degree: for crowds, where an early decision is a wrong one.

What a robot's bearings say of another robot is a mixture: one term for each bearing that may be
its, one for none. Its first two moments make one Gaussian bearing, as in expectation propagation
(Minka 2001): between rivals it is wide and says little. Nobody is ever decided on. Innovations are
judged as if poses were known worse (`heat`) than they are said to be, ever less so: neighbors'
beliefs lean on each other, and that is what keeps them from being too sure too soon.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap
from multi_localizer.team_pairs import (
    MAX_CANDIDATES,
    NONE,
    direction_covariance,
    nearest_bearings,
    weigh_pair,
    without_own,
)

_SUREST = 0.9999
_NEWS = 0.9  # of the variance that was: a mixture that leaves more of it says nothing
_LEAST_INFO = 0.05  # 1 / rad^2


@numba.njit(cache=True)
def expect_pair(
    x: np.ndarray, cov: np.ndarray, i: int, j: int, info: np.ndarray, aim: np.ndarray, heat: float
) -> tuple[float, float, float, float, float]:
    """Return the bearings that i and j should have of each other, and S11, S12, S22, hot.

    What their own Gaussian bearings have brought in is taken out.
    """
    phi, s11, s12, s22, more = direction_covariance(x, cov, i, j)
    h1, h2 = phi - x[i, 2], phi + np.pi - x[j, 2]
    w1, w2 = info[i, j], info[j, i]
    if w1 > 0.0 or w2 > 0.0:
        e1 = wrap(aim[i, j] - h1) if w1 > 0.0 else 0.0
        e2 = wrap(aim[j, i] - h2) if w2 > 0.0 else 0.0
        s11, s12, s22, r1, r2 = without_own(s11, s12, s22, e1, e2, w1, w2)
        h1, h2 = h1 + e1 - r1, h2 + e2 - r2
    most = 0.999 * np.sqrt(s11 * s22)
    s12 = min(max(s12, -most), most)
    return h1, h2, heat * (s11 + more), heat * (s12 + more), heat * (s22 + more)


@numba.njit(cache=True)
def soft_likelihoods(
    x: np.ndarray, cov: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    known: np.ndarray, info: np.ndarray, aim: np.ndarray, heat: float, visible: np.ndarray,
    gate: float, detected: float, clutter: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Weigh pairs of bearings as `pair_likelihoods` does, with Gaussian bearings in use.

    Args:
        x: Poses, (N, 3).
        cov: Their covariance, (3 N, 3 N).
        start: Where each robot's bearings begin, (N + 1,).
        bearings: (M,), rad.
        var: Their variances, (M,).
        known: Robot each bearing is said to belong to, -2 for unknown, (M,).
        info: Information of each robot's Gaussian bearing to each other one, (N, N); 0 for none.
        aim: Those bearings, (N, N), rad.
        heat: Factor of all innovations' covariances.
        visible: Chance that nothing stands between two robots, (N, N).
        gate: Deviations within which a bearing may be a robot's.
        detected: Chance that a visible robot is detected.
        clutter: Density of false bearings, 1 / rad.

    Returns:
        candidates: As there, like the next two.
        counts: How many.
        likelihoods: Of each pair of candidates.
        expected: Bearing that each robot should have of each other one, (N, N), rad.
        spread: Its variance, (N, N).
    """
    n = len(x)
    candidates = np.full((n, n, MAX_CANDIDATES), -1, dtype=np.int64)
    counts = np.zeros((n, n), dtype=np.int64)
    likelihoods = np.empty((n, n, NONE + 1, NONE + 1))  # only what is counted is written
    distances, expected, spread = np.empty(MAX_CANDIDATES), np.zeros((n, n)), np.ones((n, n))
    for i in range(n):
        for j in range(i + 1, n):
            h1, h2, s11, s12, s22 = expect_pair(x, cov, i, j, info, aim, heat)
            expected[i, j], expected[j, i], spread[i, j], spread[j, i] = h1, h2, s11, s22
            for a, b in ((i, j), (j, i)):
                counts[a, b] = nearest_bearings(
                    candidates[a, b], start[a], start[a + 1], bearings, var, known, b,
                    expected[a, b], spread[a, b], gate, distances,
                )  # fmt: skip
            weigh_pair(
                likelihoods[i, j], candidates[i, j, : counts[i, j]],
                candidates[j, i, : counts[j, i]], bearings, var, h1, h2, s11, s12, s22,
                visible[i, j], detected, clutter,
            )  # fmt: skip
    return candidates, counts, likelihoods, expected, spread


@numba.njit(cache=True)
def mixture(
    candidates: np.ndarray, beliefs: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    expected: float, spread: float,
) -> tuple[float, float]:  # fmt: skip
    """Return information and value of the Gaussian bearing that a mixture comes to; 0 for none.

    Args:
        candidates: Bearings that may be the robot's, (C,).
        beliefs: How sure each is, (C,).
        bearings: Of all robots, rad.
        var: Their variances.
        expected: Bearing at which the robot should be.
        spread: Its variance.
    """
    total, mean, square = 0.0, 0.0, 0.0
    for c in range(len(candidates)):
        k = candidates[c]
        belief, gain = min(beliefs[c], _SUREST), spread / (spread + var[k])
        e = gain * wrap(bearings[k] - expected)
        total += belief
        mean += belief * e
        square += belief * (e * e + (1.0 - gain) * spread)
    left = max(1.0 - total, 0.0) * spread + square - mean * mean
    if left >= _NEWS * spread:
        return 0.0, expected
    info = 1.0 / left - 1.0 / spread
    return info, expected + mean / left / info


@numba.njit(cache=True)
def update_aims(
    info: np.ndarray, aim: np.ndarray, candidates: np.ndarray, counts: np.ndarray,
    sure: np.ndarray, bearings: np.ndarray, var: np.ndarray, expected: np.ndarray,
    spread: np.ndarray, inertia: float,
) -> None:  # fmt: skip
    """Write new Gaussian bearings into `info` and `aim`; of the old ones `inertia` stays."""
    for i in range(len(counts)):
        for j in range(len(counts)):
            num = counts[i, j]
            new, value = mixture(
                candidates[i, j, :num], sure[i, j, :num], bearings, var, expected[i, j],
                spread[i, j],
            )  # fmt: skip
            old = inertia * info[i, j]
            both = old + (1.0 - inertia) * new
            if new > 0.0:
                off = wrap(aim[i, j] - value) if old > 0.0 else 0.0
                aim[i, j] = value + old * off / both
            info[i, j] = both if both > _LEAST_INFO else 0.0


@numba.njit(cache=True)
def as_bearings(
    info: np.ndarray, aim: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return Gaussian bearings as arrays like a problem's: start, bearings, variances, robots."""
    n, num = len(info), 0
    start = np.zeros(n + 1, dtype=np.int64)
    seen = np.empty(n * n, dtype=np.int64)
    bearings, var = np.empty(n * n), np.empty(n * n)
    for i in range(n):
        for j in range(n):
            if info[i, j] > 0.0:
                seen[num], bearings[num], var[num] = j, aim[i, j], 1.0 / info[i, j]
                num += 1
        start[i + 1] = num
    return start, bearings[:num], var[:num], seen[:num]
