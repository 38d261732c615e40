"""Who may stand at which open place, by what each robot sees himself.

Robots see each other or do not, both at once: with v the chance that nothing stands between them,
and l and l' the likelihood ratios (`team_places`) of the one's nearest bearing to the other being
his, each known robot counts for 1 - v + v l l'.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap
from multi_localizer.team_places import LEAST, MOST, NEAREST, back_ratio, ratio
from multi_localizer.team_relocate import against_prior, look_up

_EDGE_SD = 0.03  # m
_LEAST_CLEAR = 0.02
_YAW_STEP = 0.08  # rad, halved twice around the best
_YAW_REACH = 3.5  # deviations of a rough yaw
NEVER = -1e3
"""Score of a robot at a place that its rough pose rules out."""


@numba.njit(cache=True)
def look_around(
    px: float, py: float, blur: float, hidden_rate: float, detected: float, width: float,
    known: np.ndarray, bearings: np.ndarray, var: np.ndarray, is_open: np.ndarray,
    table: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return what known robots there are around a place.

    Returns:
        Of each: direction from the place, variance of that, chance v that nothing stands between,
        and likelihood ratio l' of its own bearing back, (R, 4).
    """
    around = np.empty((len(known), 4))
    for r in range(len(known)):
        dx, dy = known[r, 1] - px, known[r, 2] - py
        squared = max(dx * dx + dy * dy, NEAREST)
        phi = np.arctan2(dy, dx)
        spread = (known[r, 4] + blur * blur) / squared
        expected = phi + np.pi - known[r, 3]
        k = look_up(table, int(known[r, 0]), expected)
        around[r, 0], around[r, 1] = phi, spread
        clear = np.exp(-hidden_rate * np.sqrt(squared))
        clear *= _clear(px, py, dx, dy, r, 0.5 * width, known)
        around[r, 2] = max(clear, _LEAST_CLEAR)
        around[r, 3] = 1.0 - detected
        if k >= 0:
            v = var[k] + spread + known[r, 5]
            around[r, 3] = back_ratio(wrap(bearings[k] - expected), v, detected, is_open[k])
    return around


@numba.njit(cache=True)
def _clear(
    px: float, py: float, dx: float, dy: float, to: int, radius: float, known: np.ndarray
) -> float:
    """Return the chance that no known robot stands on the way (dx, dy) from a place to one."""
    chance = 1.0
    squared = max(dx * dx + dy * dy, NEAREST)
    length = np.sqrt(squared)
    for k in range(len(known)):
        ex, ey = known[k, 1] - px, known[k, 2] - py
        along = ex * dx + ey * dy
        if k == to or along <= 0.0 or along >= squared:
            continue
        far = (abs(ex * dy - ey * dx) / length - radius) / _EDGE_SD
        if far < 3.0:
            chance /= 1.0 + np.exp(-1.7 * far)
    return chance


@numba.njit(cache=True)
def pattern(
    u: int, yaw: float, step: float, around: np.ndarray, detected: float, bearings: np.ndarray,
    var: np.ndarray, table: np.ndarray,
) -> float:  # fmt: skip
    """Return how well robot u's bearings lead to known robots around a place at a yaw."""
    score, product = 0.0, 1.0
    for j in range(len(around)):
        expected, own = around[j, 0] - yaw, 1.0 - detected
        k = look_up(table, u, expected)
        if k >= 0:
            v = var[k] + around[j, 1] + step * step / 12.0
            own = ratio(wrap(bearings[k] - expected), v, detected)
        product *= 1.0 - around[j, 2] + around[j, 2] * own * around[j, 3]
        if product < LEAST or product > MOST:
            score, product = score + np.log(product), 1.0
    return score + np.log(product)


@numba.njit(cache=True)
def mark_pattern(
    px: float, py: float, yaw: float, step: float, blur: float, detected: float, first: int,
    last: int, mark_bearing: np.ndarray, mark_var: np.ndarray, marks: np.ndarray,
    mark_first: np.ndarray, mark_last: np.ndarray,
) -> float:  # fmt: skip
    """Return how well a robot's bearings `first:last` lead to landmarks at a pose."""
    product = 1.0
    for k in range(first, last):
        best = 0.0
        for m in range(mark_first[k], mark_last[k]):
            dx, dy = marks[m, 0] - px, marks[m, 1] - py
            spread = blur * blur / max(dx * dx + dy * dy, NEAREST)
            e = wrap(mark_bearing[k] + yaw - np.arctan2(dy, dx))
            best = max(best, ratio(e, mark_var[k] + spread + step * step / 12.0, detected))
        product *= max(best, 1.0 - detected)
    return np.log(product)


@numba.njit(cache=True)
def seat_scores(
    who: np.ndarray, places: np.ndarray, prior: np.ndarray, prior_info: np.ndarray,
    has_prior: np.ndarray, blur: float, hidden_rate: float, detected: float, width: float,
    most_prior: float, known: np.ndarray, bearings: np.ndarray, var: np.ndarray,
    is_open: np.ndarray, table: np.ndarray, mark_start: np.ndarray, mark_bearing: np.ndarray,
    mark_var: np.ndarray, marks: np.ndarray, mark_first: np.ndarray, mark_last: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the score of each robot of `who` at each place, and its yaw there, (W, P) each.

    Args:
        who: Robots, (W,).
        places: As `open_places` returns them.
        prior: Rough poses, (N, 3).
        prior_info: Their inverse covariances, (N, 3, 3).
        has_prior: Who has one, (N,).
        blur: Deviation of a place, m.
        hidden_rate: Of robots that are not known, 1 / m.
        detected: Chance that what can be seen is detected.
        width: Of a robot, m.
        most_prior: A rough pose speaks against a place no louder; where it would, nobody is put.
        known: As `known_robots` returns them.
        bearings: (M,), rad.
        var: Their variances, (M,).
        is_open: Bearings without an owner, (M,) bool.
        table: Of `nearest_table`.
        mark_start: Where each robot's bearings to landmarks begin, (N + 1,).
        mark_bearing: (K,), rad.
        mark_var: (K,), rad^2.
        marks: Positions of landmarks, (L, 2), m.
        mark_first: First landmark that each may be, (K,).
        mark_last: And the one after the last.
    """
    scores, yaws = np.full((len(who), len(places)), NEVER), np.zeros((len(who), len(places)))
    for p in range(len(places)):
        px, py = places[p, 0], places[p, 1]
        around = look_around(
            px, py, blur, hidden_rate, detected, width, known, bearings, var, is_open, table
        )
        for a in range(len(who)):
            u = who[a]
            against = against_prior(px, py, prior[u], prior_info[u])
            if has_prior[u] and against >= most_prior:
                continue
            sd = 1.0 / np.sqrt(prior_info[u, 2, 2]) if has_prior[u] else np.inf
            middle, half = 0.0, int(np.ceil(min(_YAW_REACH * sd, np.pi) / _YAW_STEP))
            best, step = -np.inf, _YAW_STEP
            for _ in range(3):
                start, best = middle, -np.inf
                for s in range(-half, half + 1):
                    turn = start + s * step
                    score = pattern(
                        u, prior[u, 2] + turn, step, around, detected, bearings, var, table
                    ) + mark_pattern(
                        px, py, prior[u, 2] + turn, step, blur, detected, mark_start[u],
                        mark_start[u + 1], mark_bearing, mark_var, marks, mark_first, mark_last,
                    ) - min(0.5 * (turn / sd) ** 2, most_prior)  # fmt: skip
                    if score > best:
                        best, middle = score, turn
                step, half = 0.5 * step, 1
            yaws[a, p] = wrap(prior[u, 2] + middle)
            scores[a, p] = best - against
    return scores, yaws
