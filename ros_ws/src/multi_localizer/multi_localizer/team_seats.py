"""Places where bearings of known robots cross that are nobody's, and who may stand at which.

A place is looked for on a grid, by the known robots' bearings alone: it is anybody's. Who stands
there is told by what he sees himself. Robots see each other or do not, both at once: with v the
chance that nothing stands between them, and l and l' the likelihood ratios of the one's nearest
bearing to the other being his, each known robot counts for

    1 - v + v l l',        l = 1 - d + d N(e; 0, s^2) / clutter,

d the chance that what can be seen is detected. In a crowd many pairs of robots have a third one on
the line between them: without him they seem to see each other. So a known robot's bearing that has
an owner may as well be of whoever stands at a place before the owner, or the owner hides it. Either
way it is no news: its N / clutter becomes the shape alone, exp(-e^2 / (2 s^2)).
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap
from multi_localizer.team_relocate import against_prior, look_up
from multi_localizer.team_yaws import CLUTTER, position_sd

_TOO_CLOSE = 0.05  # of the likelihood is left where a known robot stands
_NEAREST = 1e-2  # m^2
_LEAST, _MOST = 1e-100, 1e100  # of a product, before its logarithm is taken
_FAR = 16.0  # squared deviations beyond which a bearing is not the robot's
_BLUR = 0.35  # of a grid's step
_EDGE_SD = 0.03  # m
_LEAST_CLEAR = 0.02
_FINER = 3  # times the grid is halved around a peak
_YAW_STEP = 0.08  # rad, halved twice around the best
_YAW_REACH = 3.5  # deviations of a rough yaw
NEVER = -1e3
"""Score of a robot at a place that its rough pose rules out."""


@numba.njit(cache=True, inline="always")
def ratio(e: float, v: float, detected: float) -> float:
    """Return the likelihood ratio l of the nearest bearing, e away with variance v."""
    squared = e * e / v
    if squared > _FAR:
        return 1.0 - detected
    like = np.exp(-0.5 * squared) / np.sqrt(2.0 * np.pi * v)
    return 1.0 - detected + detected * like / CLUTTER


@numba.njit(cache=True, inline="always")
def back_ratio(e: float, v: float, detected: float, is_open: bool) -> float:
    """Return the likelihood ratio of a known robot's bearing, e off, being to a place."""
    if is_open:
        return ratio(e, v, detected)
    squared = e * e / v
    return 1.0 - detected + (detected * np.exp(-0.5 * squared) if squared < _FAR else 0.0)


@numba.njit(cache=True)
def known_robots(x: np.ndarray, cov: np.ndarray, is_placed: np.ndarray) -> np.ndarray:
    """Return the robots that are known: index, x, y, yaw, variances of place and yaw, (R, 6)."""
    known, num = np.empty((len(x), 6)), 0
    for j in range(len(x)):
        if is_placed[j]:
            known[num, 0], known[num, 1:4] = j, x[j]
            known[num, 4], known[num, 5] = position_sd(cov, j) ** 2, cov[3 * j + 2, 3 * j + 2]
            num += 1
    return known[:num]


@numba.njit(cache=True)
def crossing(
    px: float, py: float, blur: float, hidden_rate: float, detected: float, width: float,
    known: np.ndarray, bearings: np.ndarray, var: np.ndarray, is_open: np.ndarray,
    table: np.ndarray,
) -> float:  # fmt: skip
    """Return how well the known robots' bearings meet at a place, a log-likelihood ratio."""
    score, product = 0.0, 1.0
    for r in range(len(known)):
        dx, dy = px - known[r, 1], py - known[r, 2]
        squared = dx * dx + dy * dy
        if squared < width * width:
            product *= _TOO_CLOSE
        squared = max(squared, _NEAREST)
        far = hidden_rate * np.sqrt(squared)
        seen = detected / (1.0 + far + 0.5 * far * far)  # about detected * exp(-far)
        expected = np.arctan2(dy, dx) - known[r, 3]
        k = look_up(table, int(known[r, 0]), expected)
        if k >= 0:
            v = var[k] + (known[r, 4] + blur * blur) / squared + known[r, 5]
            product *= back_ratio(wrap(bearings[k] - expected), v, seen, is_open[k])
        else:
            product *= 1.0 - seen
        if product < _LEAST or product > _MOST:
            score, product = score + np.log(product), 1.0
    return score + np.log(product)


@numba.njit(cache=True)
def open_places(
    low: np.ndarray, high: np.ndarray, step: float, apart: float, most: int, around: np.ndarray,
    reach: np.ndarray, hidden_rate: float, detected: float, width: float, known: np.ndarray,
    bearings: np.ndarray, var: np.ndarray, is_open: np.ndarray, table: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return the places at which most open bearings cross: x, y, score, (P, 3), best first.

    Args:
        low: Corner of the area, (2,), m.
        high: The other one.
        step: Of the grid, m.
        apart: No two places are closer, m.
        most: At most so many.
        around: Middles of the disks that are looked at, (D, 2), m.
        reach: Their radii, (D,), m.
        hidden_rate: Robots that hide what is behind them, 1 / m along a line of sight.
        detected: Chance that what can be seen is detected.
        width: Of a robot, m.
        known: As `known_robots` returns them.
        bearings: (M,), rad.
        var: Their variances, (M,).
        is_open: Bearings without an owner, (M,) bool.
        table: Of `nearest_table`.
    """
    rows, cols = int((high[1] - low[1]) / step) + 1, int((high[0] - low[0]) / step) + 1
    scores = np.full((rows + 2, cols + 2), -np.inf)
    for r in range(rows):
        for c in range(cols):
            px, py = low[0] + c * step, low[1] + r * step
            if _is_within(px, py, around, reach):
                scores[r + 1, c + 1] = crossing(
                    px, py, _BLUR * step, hidden_rate, detected, width, known, bearings, var,
                    is_open, table,
                )  # fmt: skip
    places, found = np.empty((most, 3)), 0
    for at in _peaks(scores):
        px, py = low[0] + (at % (cols + 2) - 1) * step, low[1] + (at // (cols + 2) - 1) * step
        if found == most:
            break
        if not _is_new(px, py, places[:found], 0.5 * apart):
            continue
        px, py, score = _uphill(
            px, py, step, hidden_rate, detected, width, known, bearings, var, is_open, table
        )
        if _is_new(px, py, places[:found], apart):
            places[found, 0], places[found, 1], places[found, 2] = px, py, score
            found += 1
    return places[:found]


@numba.njit(cache=True)
def _is_within(px: float, py: float, around: np.ndarray, reach: np.ndarray) -> bool:
    for k in range(len(around)):
        if (around[k, 0] - px) ** 2 + (around[k, 1] - py) ** 2 <= reach[k] * reach[k]:
            return True
    return False


@numba.njit(cache=True)
def _is_new(px: float, py: float, places: np.ndarray, apart: float) -> bool:
    for p in range(len(places)):
        if (places[p, 0] - px) ** 2 + (places[p, 1] - py) ** 2 < apart * apart:
            return False
    return True


@numba.njit(cache=True)
def _peaks(scores: np.ndarray) -> np.ndarray:
    """Return the flat indices of local maxima within a border, the highest first."""
    rows, cols = scores.shape
    at, values = np.empty(rows * cols, dtype=np.int64), np.empty(rows * cols)
    num = 0
    for r in range(1, rows - 1):
        for c in range(1, cols - 1):
            is_low = scores[r, c] == -np.inf
            for k in range(9):
                is_low |= scores[r + k // 3 - 1, c + k % 3 - 1] > scores[r, c]
            if not is_low:
                at[num], values[num] = r * cols + c, -scores[r, c]
                num += 1
    return at[:num][np.argsort(values[:num])]


@numba.njit(cache=True)
def _uphill(
    px: float, py: float, step: float, hidden_rate: float, detected: float, width: float,
    known: np.ndarray, bearings: np.ndarray, var: np.ndarray, is_open: np.ndarray,
    table: np.ndarray,
) -> tuple[float, float, float]:  # fmt: skip
    """Return the best place around a cell of the grid, and its score, on ever finer grids."""
    score = -np.inf
    for _ in range(_FINER):
        step *= 0.5
        middle_x, middle_y, score = px, py, -np.inf
        for r in range(-1, 2):
            for c in range(-1, 2):
                qx, qy = middle_x + c * step, middle_y + r * step
                s = crossing(
                    qx, qy, _BLUR * step, hidden_rate, detected, width, known, bearings, var,
                    is_open, table,
                )  # fmt: skip
                if s > score:
                    px, py, score = qx, qy, s
    return px, py, score


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
        squared = max(dx * dx + dy * dy, _NEAREST)
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
    squared = max(dx * dx + dy * dy, _NEAREST)
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
        if product < _LEAST or product > _MOST:
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
            spread = blur * blur / max(dx * dx + dy * dy, _NEAREST)
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
