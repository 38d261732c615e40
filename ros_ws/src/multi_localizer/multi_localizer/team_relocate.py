"""A robot whose bearings fit nowhere near, or that nobody knows the place of, found by the others.

Its place is looked for on a grid: where bearings of the others that nobody else owns cross. At the
best places its heading is the turn that brings its own bearings onto the others and onto the
landmarks. Around its rough pose first; if that explains too little, wherever the team is.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap
from multi_localizer.team_yaws import CLUTTER, position_sd

BINS = 256
"""Directions at which the nearest bearing is noted."""
_CELLS = 10  # of the grid, to each side of its middle
_PLACES = 6  # looked at more closely
_DETECTED = 0.6
MOST_PRIOR = 8.0  # a rough pose may be plain wrong: it speaks against a place no louder
_YAW_STEP = 0.03


@numba.njit(cache=True, inline="always")
def _term(e: float, v: float) -> float:
    """Return the log-likelihood ratio of the nearest bearing, e away, being the robot's."""
    like = np.exp(-0.5 * e * e / v) / np.sqrt(2.0 * np.pi * v) / CLUTTER
    return np.log(1.0 - _DETECTED + _DETECTED * like)


@numba.njit(cache=True)
def nearest_table(start: np.ndarray, bearings: np.ndarray, is_open: np.ndarray) -> np.ndarray:
    """Return, for each robot and each of `BINS` directions, its nearest open bearing; -1 for none.

    Args:
        start: Where each robot's bearings begin, (N + 1,).
        bearings: (M,), rad.
        is_open: Bearings to look at, (M,) bool.
    """
    table = np.full((len(start) - 1, BINS), -1, dtype=np.int64)
    for i in range(len(start) - 1):
        for b in range(BINS):
            nearest = 7.0
            for k in range(start[i], start[i + 1]):
                if is_open[k]:
                    e = abs(wrap(bearings[k] - (2.0 * np.pi * (b + 0.5) / BINS - np.pi)))
                    if e < nearest:
                        nearest, table[i, b] = e, k
    return table


@numba.njit(cache=True, inline="always")
def look_up(table: np.ndarray, i: int, direction: float) -> int:
    """Return the bearing of robot i that is nearest to a direction, to half a bin; or -1."""
    return table[i, min(int((wrap(direction) + np.pi) * (BINS / (2.0 * np.pi))), BINS - 1)]


@numba.njit(cache=True)
def crossing_score(
    px: float, py: float, u: int, blur: float, x: np.ndarray, cov: np.ndarray,
    bearings: np.ndarray, var: np.ndarray, table: np.ndarray, is_placed: np.ndarray,
) -> float:  # fmt: skip
    """Return how well the others' open bearings meet at a place."""
    score = 0.0
    for j in range(len(x)):
        if not is_placed[j] or j == u:
            continue
        dx, dy = px - x[j, 0], py - x[j, 1]
        squared = max(dx * dx + dy * dy, 1e-2)
        expected = np.arctan2(dy, dx) - x[j, 2]
        k = look_up(table, j, expected)
        if k >= 0:
            spread = position_sd(cov, j) ** 2 + blur * blur
            v = var[k] + spread / squared + cov[3 * j + 2, 3 * j + 2]
            score += _term(wrap(bearings[k] - expected), v)
    return score


@numba.njit(cache=True)
def pattern_score(
    px: float, py: float, yaw: float, u: int, blur: float, x: np.ndarray, cov: np.ndarray,
    bearings: np.ndarray, var: np.ndarray, table: np.ndarray, is_placed: np.ndarray,
    mark_robot: np.ndarray, mark_bearing: np.ndarray, mark_var: np.ndarray, marks: np.ndarray,
    mark_first: np.ndarray, mark_last: np.ndarray,
) -> float:  # fmt: skip
    """Return how well robot u's own bearings lead to the others and to landmarks at a pose."""
    score = 0.0
    for j in range(len(x)):
        if not is_placed[j] or j == u:
            continue
        dx, dy = x[j, 0] - px, x[j, 1] - py
        squared = max(dx * dx + dy * dy, 1e-2)
        expected = np.arctan2(dy, dx) - yaw
        k = look_up(table, u, expected)
        if k >= 0:
            spread = position_sd(cov, j) ** 2 + blur * blur
            v = var[k] + spread / squared + _YAW_STEP**2 / 12.0
            score += _term(wrap(bearings[k] - expected), v)
    for k in range(len(mark_robot)):
        if mark_robot[k] != u:
            continue
        nearest, v = 7.0, 1.0
        for m in range(mark_first[k], mark_last[k]):
            dx, dy = marks[m, 0] - px, marks[m, 1] - py
            e = abs(wrap(mark_bearing[k] + yaw - np.arctan2(dy, dx)))
            if e < nearest:
                nearest = e
                v = mark_var[k] + blur * blur / max(dx * dx + dy * dy, 1e-2) + _YAW_STEP**2 / 12.0
        score += _term(nearest, v)
    return score


@numba.njit(cache=True, inline="always")
def against_prior(px: float, py: float, prior: np.ndarray, info: np.ndarray) -> float:
    """Return how much a rough pose speaks against a place, `MOST_PRIOR` at most."""
    dx, dy = px - prior[0], py - prior[1]
    squared = info[0, 0] * dx * dx + 2.0 * info[0, 1] * dx * dy + info[1, 1] * dy * dy
    return min(0.5 * squared, MOST_PRIOR)


@numba.njit(cache=True)
def best_places(
    u: int, middle: np.ndarray, half: np.ndarray, prior: np.ndarray, info: np.ndarray,
    x: np.ndarray, cov: np.ndarray, bearings: np.ndarray, var: np.ndarray, table: np.ndarray,
    is_placed: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return the places of a grid, refined once, at which most bearings cross: x, y, score."""
    side = 2 * _CELLS + 1
    step = np.array([half[0] / _CELLS, half[1] / _CELLS])
    blur = 0.3 * np.sqrt(step[0] * step[1])
    scores = np.empty((side, side))
    for r in range(side):
        for c in range(side):
            px, py = middle[0] + (c - _CELLS) * step[0], middle[1] + (r - _CELLS) * step[1]
            scores[r, c] = crossing_score(
                px, py, u, blur, x, cov, bearings, var, table, is_placed
            ) - against_prior(px, py, prior, info)
    found = np.full((_PLACES, 3), -np.inf)
    for p in range(_PLACES):
        at = np.argmax(scores)
        row, col = at // side, at % side
        px = middle[0] + (col - _CELLS) * step[0]
        py = middle[1] + (row - _CELLS) * step[1]
        for r in range(-2, 3):
            for c in range(-2, 3):
                qx, qy = px + 0.3 * c * step[0], py + 0.3 * r * step[1]
                score = crossing_score(
                    qx, qy, u, 0.4 * blur, x, cov, bearings, var, table, is_placed
                ) - against_prior(qx, qy, prior, info)
                if score > found[p, 2]:
                    found[p, 0], found[p, 1], found[p, 2] = qx, qy, score
        scores[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2] = -np.inf
    return found


@numba.njit(cache=True)
def best_pose(
    u: int, places: np.ndarray, yaw: float, reach: float, blur: float, x: np.ndarray,
    cov: np.ndarray, bearings: np.ndarray, var: np.ndarray, table: np.ndarray,
    is_placed: np.ndarray, mark_robot: np.ndarray, mark_bearing: np.ndarray, mark_var: np.ndarray,
    marks: np.ndarray, mark_first: np.ndarray, mark_last: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return x, y, yaw and score of the best turn at the best of some places."""
    best = np.array([0.0, 0.0, 0.0, -np.inf])
    half = int(np.ceil(min(reach, np.pi) / _YAW_STEP))
    for p in range(len(places)):
        if not np.isfinite(places[p, 2]):
            continue
        for s in range(-half, half + 1):
            turned = yaw + s * _YAW_STEP
            score = places[p, 2] + pattern_score(
                places[p, 0], places[p, 1], turned, u, blur, x, cov, bearings, var, table,
                is_placed, mark_robot, mark_bearing, mark_var, marks, mark_first, mark_last,
            )  # fmt: skip
            if reach < np.pi:
                score -= min(4.5 * (s * _YAW_STEP / reach) ** 2, MOST_PRIOR)
            if score > best[3]:
                best[0], best[1], best[2], best[3] = places[p, 0], places[p, 1], turned, score
    best[2] = wrap(best[2])
    return best
