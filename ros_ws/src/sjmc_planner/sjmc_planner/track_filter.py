"""Where something is and how it moves: standing or walking, both at once (IMM).

Two Kalman filters run side by side for each track (Blom and Bar-Shalom 1988, the interacting
multiple model filter): one that stands and one that walks with nearly constant velocity. What they
say is mixed by the probability of each. State: x, y, vx, vy over the ground.
"""

from __future__ import annotations

import numba
import numpy as np

STANDS, WALKS = 0, 1
_DRIFT = 0.05  # middles of standing things move as they are seen from elsewhere, m per sqrt(s)
_STILL = 0.05  # deviation of the velocity of what stands, m/s
_SETS_OUT = 0.8  # deviation of the velocity of what begins to walk, m/s
_STANDS_S, _WALKS_S = 20.0, 5.0  # for how long, on average
_LEAST = 1e-3  # neither is ever ruled out
_TEMPERED = 0.5  # errors of one scan and the next are alike, so they do not tell as much
_MOST_TOLD = 3.0  # by one scan, in the logarithm


@numba.njit(cache=True, nogil=True)
def start(mean, cov, x, y, sd):  # type: ignore[no-untyped-def]
    """Begin a track: write the means (2, 4) and the covariances (2, 4, 4)."""
    mean[:], cov[:] = 0.0, 0.0
    for m in range(2):
        mean[m, 0], mean[m, 1] = x, y
        cov[m, 0, 0] = cov[m, 1, 1] = sd * sd
    cov[STANDS, 2, 2] = cov[STANDS, 3, 3] = _STILL**2
    cov[WALKS, 2, 2] = cov[WALKS, 3, 3] = _SETS_OUT**2


@numba.njit(cache=True, nogil=True)
def mix(mean, cov, p_walks):  # type: ignore[no-untyped-def]
    """Return the mean (4,) and the covariance (4, 4) of both together."""
    p = np.array([1.0 - p_walks, p_walks])
    mixed = p[0] * mean[0] + p[1] * mean[1]
    spread = np.zeros((4, 4))
    for m in range(2):
        for i in range(4):
            for j in range(4):
                off = (mean[m, i] - mixed[i]) * (mean[m, j] - mixed[j])
                spread[i, j] += p[m] * (cov[m, i, j] + off)
    return mixed, spread


@numba.njit(cache=True, nogil=True)
def predict(mean, cov, p_walks, accel, dt):  # type: ignore[no-untyped-def]
    """Let time pass, in place; return the probability that it walks after that."""
    sets_out, halts = 1.0 - np.exp(-dt / _STANDS_S), 1.0 - np.exp(-dt / _WALKS_S)
    p_after = p_walks * (1.0 - halts) + (1.0 - p_walks) * sets_out
    from_stands = (1.0 - p_walks) * sets_out / max(p_after, 1e-12)  # of those that walk now
    from_walks = p_walks * halts / max(1.0 - p_after, 1e-12)  # of those that stand now
    means, covs = mean.copy(), cov.copy()
    for i in range(2, 4):
        covs[STANDS, i, i] += _SETS_OUT**2
    mean[WALKS], cov[WALKS] = mix(means, covs, 1.0 - from_stands)
    mean[STANDS], cov[STANDS] = mix(means, covs, from_walks)
    _stand(mean[STANDS], cov[STANDS], dt)
    _walk(mean[WALKS], cov[WALKS], accel, dt)
    return p_after


@numba.njit(cache=True, nogil=True)
def _stand(mean, cov, dt):  # type: ignore[no-untyped-def]
    mean[2] = mean[3] = 0.0
    for i in range(2, 4):
        for j in range(4):
            cov[i, j] = cov[j, i] = 0.0
        cov[i, i] = _STILL**2
    cov[0, 0] += _DRIFT**2 * dt
    cov[1, 1] += _DRIFT**2 * dt


@numba.njit(cache=True, nogil=True)
def _walk(mean, cov, accel, dt):  # type: ignore[no-untyped-def]
    mean[0] += dt * mean[2]
    mean[1] += dt * mean[3]
    for j in range(4):
        cov[0, j] += dt * cov[2, j]
        cov[1, j] += dt * cov[3, j]
    for i in range(4):
        cov[i, 0] += dt * cov[i, 2]
        cov[i, 1] += dt * cov[i, 3]
    q = accel * accel  # white acceleration
    for k in range(2):
        cov[k, k] += q * dt**3 / 3.0
        cov[k, k + 2] += q * dt**2 / 2.0
        cov[k + 2, k] += q * dt**2 / 2.0
        cov[k + 2, k + 2] += q * dt


@numba.njit(cache=True, nogil=True)
def distance2(mean, cov, x, y, variance):  # type: ignore[no-untyped-def]
    """Return the squared Mahalanobis distance of a place, and the logarithm of its spread."""
    a, b, c = cov[0, 0] + variance, cov[0, 1], cov[1, 1] + variance
    det = a * c - b * b
    dx, dy = x - mean[0], y - mean[1]
    return (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / det, np.log(det)


@numba.njit(cache=True, nogil=True)
def correct(mean, cov, p_walks, x, y, variance, told, is_free):  # type: ignore[no-untyped-def]
    """Take a place into both, in place; return the probability that it walks after that.

    Args:
        mean: Means, shape (2, 4).
        cov: Covariances, shape (2, 4, 4).
        p_walks: Probability that it walks before.
        x: Where it was seen, m.
        y: Where it was seen, m.
        variance: Of that, m^2.
        told: What the space it stands in tells, logarithm of the odds that it moves.
        is_free: Whether that space was free a moment ago; else its place cannot tell that it
            walks: what is not known to have moved may only come into view.
    """
    like = np.empty(2)
    for m in range(2):
        d2, log_det = distance2(mean[m], cov[m], x, y, variance)
        like[m] = -0.5 * (d2 + log_det)
        _kalman(mean[m], cov[m], x, y, variance)
    place = min(max(_TEMPERED * (like[WALKS] - like[STANDS]), -_MOST_TOLD), _MOST_TOLD)
    if not is_free:
        place = min(place, 0.0)
    odds = np.log(p_walks / (1.0 - p_walks)) + place + told
    return min(max(1.0 / (1.0 + np.exp(-odds)), _LEAST), 1.0 - _LEAST)


@numba.njit(cache=True, nogil=True)
def _kalman(mean, cov, x, y, variance):  # type: ignore[no-untyped-def]
    a, b, c = cov[0, 0] + variance, cov[0, 1], cov[1, 1] + variance
    det = a * c - b * b
    dx, dy = x - mean[0], y - mean[1]
    first, second = cov[:, 0].copy(), cov[:, 1].copy()
    for i in range(4):
        k0 = (first[i] * c - second[i] * b) / det
        k1 = (second[i] * a - first[i] * b) / det
        mean[i] += k0 * dx + k1 * dy
        for j in range(4):
            cov[i, j] -= k0 * first[j] + k1 * second[j]
