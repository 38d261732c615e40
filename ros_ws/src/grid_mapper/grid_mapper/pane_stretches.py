"""Which stretches of a pane's line are glass: log-odds along the line, joined with posts and walls.

Along the line, in steps of a cell, echoes from there speak for glass, and laser beams that came
back from there though most cross it. Sonars that faced the stretch squarely and heard nothing from
there speak against it, and so does the way of the robot through it. A miss at a slant says nothing,
for there glass is a mirror. Where nothing was heard either way, a pane is carried on to the next
opaque thing that the laser sees on the line: a post, a frame, a wall.
"""

from __future__ import annotations

import numba
import numpy as np

from grid_mapper.bayes_config import BayesConfig
from grid_mapper.echo_judging import wrapped
from grid_mapper.opaque_cells import Cells, at
from grid_mapper.pane_lines import PaneLine, lies_on

SPOT_M = 0.1
"""Half the length of glass that sends an echo back: the first Fresnel zone at 50 kHz and 2 m."""
SQUARE_RAD = 0.19
"""Glass met within this of its normal answers for sure: the critical angle less two deviations."""
EDGE_RAD = 0.035
"""A miss says nothing of what lies this near the edge of the cone."""
BODY_M = 0.12
"""A sonar so near the line was on it: the robot went through."""
WENT_THROUGH = 10.0
"""Misses that this counts for."""
FREE_BEYOND_M = 0.15
"""A miss counts where the cone was free so far beyond the line."""
MIN_HITS = 3
"""Beams come back from dirt too; from one place so many do not in passing."""
NEUTRAL, WEAK, GLASS, OPEN, OPAQUE = 0, 1, 2, 3, 4


def stretches(line: PaneLine, views: np.ndarray, config: BayesConfig, cells: Cells) -> np.ndarray:
    """Return the stretches of a line that are glass, as ends (from, to) along it, shape (N, 2), m.

    Args:
        line: The line.
        views: All views.
        config: Its log-odds, `max_bay_m` and `weak_share` are used.
        cells: Of the laser.
    """
    step = cells.resolution
    first = line.low - config.line_reach_m
    num = int(np.ceil((line.high + config.line_reach_m - first) / step))
    states = _states(line, views, config, cells, first, num)
    is_glass = _filled(states, round(config.max_bay_m / step), config.weak_share)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], is_glass, [False])).astype(np.int8)))
    return np.asarray(first + step * edges.reshape(-1, 2))


def _states(
    line: PaneLine, views: np.ndarray, config: BayesConfig, cells: Cells, first: float, num: int
) -> np.ndarray:
    """Return what each bin of a line is, from `first` on, shape (num,)."""
    step, theta, rho = cells.resolution, line.theta, line.rho
    tolerance = config.range_tolerance_m, config.range_tolerance_share
    echoes, weak, newest = heard(views, theta, rho, first, step, num, *tolerance)
    missed, newer = missing(views, theta, rho, first, step, newest)
    is_opaque, hits = seen(cells, theta, rho, first, num)
    odds = config.echo_log_odds * echoes + config.miss_log_odds * missed
    odds += config.hit_log_odds * (hits >= MIN_HITS)
    has_gone = (newer >= config.moved_misses) & (newest > 0)
    along = first + (np.arange(num) + 0.5) * step
    is_near = (along > line.low - config.max_bay_m) & (along < line.high + config.max_bay_m)
    states = np.where((weak > 0.0) | (hits > 0) | (odds > config.min_log_odds), WEAK, NEUTRAL)
    states[is_near & (odds > config.min_log_odds)] = GLASS
    states[(odds < -config.min_log_odds) | has_gone] = OPEN
    states[is_opaque] = OPAQUE
    return np.asarray(states)


def _filled(states: np.ndarray, max_bins: int, weak_share: float) -> np.ndarray:
    """Return which bins are glass once bays between glass and glass or opaque bins are filled."""
    is_glass = states == GLASS
    ends = np.flatnonzero(states >= GLASS)
    for a, b in zip(ends[:-1], ends[1:], strict=True):
        kinds = {int(states[a]), int(states[b])}
        if OPEN in kinds or not 1 < b - a <= max_bins + 1:
            continue
        if GLASS in kinds or (states[a + 1 : b] == WEAK).mean() >= weak_share:
            is_glass[a + 1 : b] = True
    return np.asarray(is_glass)


@numba.njit(cache=True, inline="always")
def _spot(along, first, step, num):  # type: ignore[no-untyped-def]
    """Return the first bin of the spot that sends an echo back, and the first beyond it."""
    low = int(np.floor((along - SPOT_M - first) / step))
    high = int(np.ceil((along + SPOT_M - first) / step))
    return min(max(low, 0), num), min(max(high, 0), num)


@numba.njit(cache=True)
def heard(views, theta, rho, first, step, num, tolerance, share):  # type: ignore[no-untyped-def]
    """Return the weights of open and of explained echoes of every bin, and the newest one's stamp.

    Args:
        views: All views.
        theta: Of the line, rad.
        rho: Of the line, m.
        first: Where the first bin begins along the line, m.
        step: Length of a bin, m.
        num: How many there are.
        tolerance: Of a range, m.
        share: Of a range beside, in shares of it.
    """
    c, s = np.cos(theta), np.sin(theta)
    echoes, weak, newest = np.zeros(num), np.zeros(num), np.zeros(num, np.int64)
    for i in range(len(views)):
        view = views[i]
        a, b = _spot(c * view.y - s * view.x, first, step, num)
        fit = lies_on(view, theta, c, s, rho, tolerance, share) if a < b else 0
        for k in range(a, b) if fit > 0 else range(0):
            if fit == 2:
                echoes[k] += view.weight
            else:
                weak[k] += view.weight
            newest[k] = max(newest[k], view.stamp_ns)
    return echoes, weak, newest


@numba.njit(cache=True)
def missing(views, theta, rho, first, step, newest):  # type: ignore[no-untyped-def]
    """Return how often every bin was faced and not heard, and how often since its newest echo."""
    c, s, num = np.cos(theta), np.sin(theta), len(newest)
    missed, newer = np.zeros(num), np.zeros(num)
    for i in range(len(views)):
        view = views[i]
        along, d = c * view.y - s * view.x, rho - (c * view.x + s * view.y)
        lost = view.weight
        if abs(d) < BODY_M:
            low, high, lost = along - SPOT_M, along + SPOT_M, WENT_THROUGH
        elif view.r > abs(d) + FREE_BEYOND_M:
            low, high = _faced(view, theta, along, d)
        else:
            continue
        a = max(int(np.ceil((low - first) / step - 0.5)), 0)
        b = min(int(np.floor((high - first) / step - 0.5)) + 1, num)
        for k in range(a, b):
            missed[k] += lost
            newer[k] += lost if view.stamp_ns > newest[k] else 0.0
    return missed, newer


@numba.njit(cache=True, inline="always")
def _faced(view, theta, along, d):  # type: ignore[no-untyped-def]
    """Return from where to where a cone met a line so squarely that glass had answered, m."""
    off = wrapped(view.yaw - theta if d > 0.0 else view.yaw - theta - np.pi)
    low = max(off - view.half + EDGE_RAD, -SQUARE_RAD)
    high = min(off + view.half - EDGE_RAD, SQUARE_RAD)
    if high <= low:
        return 0.0, -1.0
    if d > 0.0:
        return along + d * np.tan(low), along + d * np.tan(high)
    return along + d * np.tan(high), along + d * np.tan(low)


@numba.njit(cache=True)
def seen(cells, theta, rho, first, num):  # type: ignore[no-untyped-def]
    """Return where the laser sees something opaque on the line or beside, and most hits there."""
    c, s, step = np.cos(theta), np.sin(theta), cells.resolution
    is_opaque, most_hits = np.zeros(num, np.bool_), np.zeros(num, np.uint8)
    for k in range(num):
        along = first + (k + 0.5) * step
        for side in range(-1, 2):
            d = rho + side * step
            log_odds, hits = at(cells, d * c - along * s, d * s + along * c)
            is_opaque[k] |= log_odds > 0.0
            most_hits[k] = max(most_hits[k], hits)
    return is_opaque, most_hits
