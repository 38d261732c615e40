"""How likely two bearings are those of two robots to each other, given all poses' joint covariance.

If i and j see each other, their bearings a and b follow from both poses: with phi the direction
from i to j, a = phi - yaw_i and b = phi + pi - yaw_j, up to noise. The two innovations share phi's
uncertainty and their sum does not hold it at all: a pair is told far better than a single bearing.

A bearing that has already been used in the fit pulled the poses its way. Its own information W is
taken out again before it is judged: S = (1 - S0 W)^-1 S0, and the innovation (1 - S0 W)^-1 e.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import robust_weight, wrap

MAX_CANDIDATES = 8
"""A robot is looked for among so many bearings of another at most."""
NONE = MAX_CANDIDATES
"""Last row and column of a pair's likelihoods: this robot does not see the other."""
_TINY = 1e-12
_NEVER = 80.0  # squared deviations


@numba.njit(cache=True)
def direction_covariance(
    x: np.ndarray, cov: np.ndarray, i: int, j: int
) -> tuple[float, float, float, float, float]:
    """Return phi, the covariance of (phi - yaw_i, phi - yaw_j) as S11, S12, S22, and what to add.

    What to add to each is phi's variance of second order: near each other phi may be anywhere.
    """
    p, q = 3 * i, 3 * j
    dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
    squared = max(dx * dx + dy * dy, 1e-4)
    a, b = -dy / squared, dx / squared  # phi's derivative by p_j
    xx = cov[p, p] + cov[q, q] - 2.0 * cov[p, q]
    yy = cov[p + 1, p + 1] + cov[q + 1, q + 1] - 2.0 * cov[p + 1, q + 1]
    xy = cov[p, p + 1] + cov[q, q + 1] - cov[p, q + 1] - cov[p + 1, q]
    v = a * a * xx + b * b * yy + 2.0 * a * b * xy
    with_i = a * (cov[q, p + 2] - cov[p, p + 2]) + b * (cov[q + 1, p + 2] - cov[p + 1, p + 2])
    with_j = a * (cov[q, q + 2] - cov[p, q + 2]) + b * (cov[q + 1, q + 2] - cov[p + 1, q + 2])
    s11 = max(v - 2.0 * with_i + cov[p + 2, p + 2], _TINY)
    s22 = max(v - 2.0 * with_j + cov[q + 2, q + 2], _TINY)
    s12 = v - with_i - with_j + cov[p + 2, q + 2]
    return np.arctan2(dy, dx), s11, s12, s22, ((xx + yy) / (2.0 * squared)) ** 2


@numba.njit(cache=True)
def without_own(
    s11: float, s12: float, s22: float, e1: float, e2: float, w1: float, w2: float
) -> tuple[float, float, float, float, float]:
    """Take two bearings of information w1, w2 and innovations e1, e2 out of what they changed.

    Returns:
        (S11, S12, S22, e1, e2) as if the bearings had not been used.
    """
    a, b = 1.0 - s11 * w1, -s12 * w2
    c, d = -s12 * w1, 1.0 - s22 * w2
    det = max(a * d - b * c, 1e-9)
    return (
        max((d * s11 - b * s12) / det, _TINY),
        (d * s12 - b * s22) / det,
        max((a * s22 - c * s12) / det, _TINY),
        (d * e1 - b * e2) / det,
        (a * e2 - c * e1) / det,
    )


@numba.njit(cache=True)
def nearest_bearings(
    into: np.ndarray, first: int, last: int, bearings: np.ndarray, var: np.ndarray,
    known: np.ndarray, who: int, expected: float, spread: float, gate: float,
    distances: np.ndarray,
) -> int:  # fmt: skip
    """Write the bearings that may be robot `who`'s, nearest first, into `into`; return how many.

    `distances` is room for as many, to work in.
    """
    found = 0
    for k in range(first, last):
        e = wrap(bearings[k] - expected)
        squared = e * e / (spread + var[k])
        if known[k] == who:
            squared = 0.0
        elif known[k] != -2 or squared > gate * gate:
            continue
        at = min(found, MAX_CANDIDATES)
        while at > 0 and distances[at - 1] > squared:
            if at < MAX_CANDIDATES:
                distances[at], into[at] = distances[at - 1], into[at - 1]
            at -= 1
        if at < MAX_CANDIDATES:
            distances[at], into[at] = squared, k
            found = min(found + 1, MAX_CANDIDATES)
    return found


@numba.njit(cache=True)
def pair_likelihoods(
    x: np.ndarray, cov: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    known: np.ndarray, seen: np.ndarray, limit: float, visible: np.ndarray, gate: float,
    detected: float, clutter: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Weigh, for each pair of robots, each pair of bearings against both being false.

    Args:
        x: Poses, (N, 3).
        cov: Their covariance, (3 N, 3 N).
        start: Where each robot's bearings begin, (N + 1,).
        bearings: (M,), rad.
        var: Their variances, (M,).
        known: Robot each bearing is said to belong to, -2 for unknown, (M,).
        seen: Robot that each bearing counted for in the fit, negative for none, (M,).
        limit: Deviations beyond which a residual counted less there.
        visible: Chance that nothing stands between two robots, (N, N).
        gate: Deviations within which a bearing may be a robot's.
        detected: Chance that a visible robot is detected.
        clutter: Density of false bearings, 1 / rad.

    Returns:
        candidates: Bearings of i that may be j's, (N, N, MAX_CANDIDATES).
        counts: How many, (N, N).
        likelihoods: Of each pair of candidates, i < j: (N, N, MAX_CANDIDATES + 1, same); the last
            row or column stands for not seen.
    """
    n = len(x)
    candidates = np.full((n, n, MAX_CANDIDATES), -1, dtype=np.int64)
    counts = np.zeros((n, n), dtype=np.int64)
    likelihoods = np.empty((n, n, NONE + 1, NONE + 1))  # only what is counted is written
    distances = np.empty(MAX_CANDIDATES)
    for i in range(n):
        for j in range(i + 1, n):
            phi, s11, s12, s22, more = direction_covariance(x, cov, i, j)
            h1, h2 = phi - x[i, 2], phi + np.pi - x[j, 2]
            e1, w1 = _own_use(i, j, h1, start, bearings, var, seen, limit)
            e2, w2 = _own_use(j, i, h2, start, bearings, var, seen, limit)
            if w1 > 0.0 or w2 > 0.0:
                s11, s12, s22, r1, r2 = without_own(s11, s12, s22, e1, e2, w1, w2)
                h1, h2 = h1 + e1 - r1, h2 + e2 - r2
            most = 0.999 * np.sqrt(s11 * s22)
            s11, s12, s22 = s11 + more, min(max(s12, -most), most) + more, s22 + more
            counts[i, j] = nearest_bearings(
                candidates[i, j], start[i], start[i + 1], bearings, var, known, j, h1, s11, gate,
                distances,
            )  # fmt: skip
            counts[j, i] = nearest_bearings(
                candidates[j, i], start[j], start[j + 1], bearings, var, known, i, h2, s22, gate,
                distances,
            )  # fmt: skip
            weigh_pair(
                likelihoods[i, j], candidates[i, j, : counts[i, j]],
                candidates[j, i, : counts[j, i]], bearings, var, h1, h2, s11, s12, s22,
                visible[i, j], detected, clutter,
            )  # fmt: skip
    return candidates, counts, likelihoods


@numba.njit(cache=True)
def _own_use(
    i: int, j: int, expected: float, start: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    seen: np.ndarray, limit: float,
) -> tuple[float, float]:  # fmt: skip
    """Return innovation and information of robot i's bearing that counted as j's; 0, 0 for none."""
    for k in range(start[i], start[i + 1]):
        if seen[k] == j:
            e = wrap(bearings[k] - expected)
            return e, robust_weight(e * e / var[k], limit) / var[k]
    return 0.0, 0.0


@numba.njit(cache=True)
def weigh_pair(
    into: np.ndarray, of_i: np.ndarray, of_j: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    h1: float, h2: float, s11: float, s12: float, s22: float, visible: float, detected: float,
    clutter: float,
) -> None:  # fmt: skip
    """Write the likelihood ratios of one pair of robots into `into`."""
    missed = 1.0 - detected
    into[NONE, NONE] = visible * missed * missed + 1.0 - visible
    single = visible * detected * missed / clutter
    for c in range(len(of_i)):
        e, v = wrap(bearings[of_i[c]] - h1), s11 + var[of_i[c]]
        into[c, NONE] = single * np.exp(-0.5 * e * e / v) / np.sqrt(2.0 * np.pi * v)
    for c in range(len(of_j)):
        e, v = wrap(bearings[of_j[c]] - h2), s22 + var[of_j[c]]
        into[NONE, c] = single * np.exp(-0.5 * e * e / v) / np.sqrt(2.0 * np.pi * v)
    both = visible * (detected / clutter) ** 2 / (2.0 * np.pi)
    last1, last2, inverse, scale = -1.0, -1.0, 0.0, 0.0
    for c in range(len(of_i)):
        e, v1 = wrap(bearings[of_i[c]] - h1), s11 + var[of_i[c]]
        for d in range(len(of_j)):
            f, v2 = wrap(bearings[of_j[d]] - h2), s22 + var[of_j[d]]
            if v1 != last1 or v2 != last2:  # most bearings are alike
                last1, last2, inverse = v1, v2, 1.0 / max(v1 * v2 - s12 * s12, _TINY * _TINY)
                scale = both * np.sqrt(inverse)
            squared = max((v2 * e * e - 2.0 * s12 * e * f + v1 * f * f) * inverse, 0.0)
            into[c, d] = scale * np.exp(-0.5 * squared) if squared < _NEVER else 0.0
