"""Places where bearings of known robots cross that are nobody's.

A place is looked for on a grid, by the known robots' bearings alone: it is anybody's. With e how
far a robot's bearing nearest to a place is off, s^2 its variance and d the chance that who stands
there is seen and detected, its likelihood ratio is

    l = 1 - d + d N(e; 0, s^2) / clutter.

In a crowd many pairs of robots have a third one on the line between them: without him they seem to
see each other. So a bearing that has an owner may as well be of whoever stands at a place before
the owner, or the owner hides it. Either way it is no news: its N / clutter becomes the shape alone,
exp(-e^2 / (2 s^2)).
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap
from multi_localizer.team_relocate import look_up
from multi_localizer.team_yaws import CLUTTER, position_sd

NEAREST = 1e-2
"""Squared distances count as no less, m^2."""
LEAST, MOST = 1e-100, 1e100
"""Of a product, before its logarithm is taken."""
_TOO_CLOSE = 0.05  # of the likelihood is left where a known robot stands
_FAR = 16.0  # squared deviations beyond which a bearing is not the robot's
_BLUR = 0.35  # of a grid's step
_FINER = 3  # times the grid is halved around a peak


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
        squared = max(squared, NEAREST)
        far = hidden_rate * np.sqrt(squared)
        seen = detected / (1.0 + far + 0.5 * far * far)  # about detected * exp(-far)
        expected = np.arctan2(dy, dx) - known[r, 3]
        k = look_up(table, int(known[r, 0]), expected)
        if k >= 0:
            v = var[k] + (known[r, 4] + blur * blur) / squared + known[r, 5]
            product *= back_ratio(wrap(bearings[k] - expected), v, seen, is_open[k])
        else:
            product *= 1.0 - seen
        if product < LEAST or product > MOST:
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
