"""Which stretches of a pane's line are glass: log-odds along the line, joined with posts and walls.

Along the line, in steps of a cell, echoes from there speak for glass, and laser beams that came
back from there though most cross it. Sonars that faced the stretch squarely and heard nothing from
there speak against it, and so does the way of the robot through it. A miss at a slant says nothing,
for there glass is a mirror, and misses from afar say little, for what silences one silences all.
What moves is known by its newest readings: misses older than some echoes are forgotten, and misses
newer than all echoes clear. Where nothing was heard either way, a pane is carried on to the next
opaque thing that the laser sees on the line: a post, a frame, a wall.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from grid_mapper.bayes_config import BayesConfig
from grid_mapper.echo_judging import wrapped
from grid_mapper.opaque_cells import Cells, at
from grid_mapper.pane_bays import GLASS, NEUTRAL, OPAQUE, OPEN, WEAK, filled, in_doubt, supported
from grid_mapper.pane_lines import PaneLine, along_line, lies_on

SPOT_M = 0.1
"""Half the length of glass that sends an echo back: the first Fresnel zone at 50 kHz and 2 m."""
EDGE_RAD = 0.035
"""A miss says nothing of what lies this near the edge of the cone."""
TOO_NEAR_M = 0.12
"""A sonar so near a line hears nothing of it, glass or not."""
WENT_THROUGH = 10.0
"""Misses that a way from one side of the line to the other counts for."""
STEP_M, STEP_NS = 0.5, 1_000_000_000
"""Views after each other no farther apart than this tell the way between."""
FREE_BEYOND_M = 0.15
"""A miss counts where the cone was free so far beyond the line."""
MIN_HITS = 3
"""Beams come back from dirt too; from one place so many do not in passing."""
POST_M = 0.3
"""What is opaque over more than this along a line is a wall."""


class Stretches(NamedTuple):
    """Stretches of a line, as ends (from, to) along it, shape (N, 2) each, m.

    Attributes:
        glass: What is believed to be glass.
        in_doubt: What may be glass as well as open; see `pane_bays.in_doubt`.
    """

    glass: np.ndarray
    in_doubt: np.ndarray


def stretches(line: PaneLine, views: np.ndarray, config: BayesConfig, cells: Cells) -> Stretches:
    """Return the stretches of a line that are glass, and those that may be.

    Args:
        line: The line; one without echoes is a row of posts from `low` to `high`.
        views: All views.
        config: Its log-odds, `max_bay_m`, `weak_share` and what a pane needs are used.
        cells: Of the laser.
    """
    step, first = cells.resolution, line.low - config.line_reach_m
    num = int(np.ceil((line.high + config.line_reach_m - first) / step))
    states = _states(line, views, config, cells, first, num)
    max_bins, post_bins = (round(m / step) for m in (config.max_bay_m, POST_M))
    if len(line.echoes):
        bins = np.floor((along_line(views[line.echoes], line.theta) - first) / step)
        is_carried = supported(states, views[line.echoes], bins.astype(np.int64), config)
        is_start = is_glass = filled(states, is_carried, max_bins, config.weak_share)
    else:
        along = first + (np.arange(num) + 0.5) * step
        states[states == GLASS] = WEAK  # beams from dirt; no echo
        is_start = (states == OPAQUE) & (along > line.low) & (along < line.high)
        is_glass = np.zeros(num, bool)
    doubt = in_doubt(states, is_start, max_bins, post_bins) & ~is_glass
    return Stretches(*(first + step * _runs(mask) for mask in (is_glass, doubt)))


def _runs(mask: np.ndarray) -> np.ndarray:
    """Return where runs of True begin and end, shape (N, 2)."""
    return np.flatnonzero(np.diff(np.pad(mask.astype(np.int8), 1))).reshape(-1, 2)


def _states(
    line: PaneLine, views: np.ndarray, config: BayesConfig, cells: Cells, first: float, num: int
) -> np.ndarray:
    """Return what each bin of a line is, from `first` on, shape (num,)."""
    step, theta, rho = cells.resolution, line.theta, line.rho
    axis = theta, rho, first, step
    tolerance = config.range_tolerance_m, config.range_tolerance_share
    order = np.argsort(views["stamp_ns"], kind="stable")
    echoes, weak, newest, since, is_on = heard(
        views, order[::-1], axis, num, *tolerance, config.moved_misses
    )
    sure = config.critical_rad - 2.0 * config.critical_sd_rad
    missed, newer = missing(views, order, axis, newest, since, is_on, sure, config.trusted_m)
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


@numba.njit(cache=True, inline="always")
def _spot(along, first, step, num):  # type: ignore[no-untyped-def]
    """Return the first bin of the spot that sends an echo back, and the first beyond it."""
    low = int(np.floor((along - SPOT_M - first) / step))
    high = int(np.ceil((along + SPOT_M - first) / step))
    return min(max(low, 0), num), min(max(high, 0), num)


@numba.njit(cache=True, nogil=True)
def heard(  # type: ignore[no-untyped-def]
    views, order, axis, num, tolerance, share, enough
):
    """Return each bin's open and explained echoes, two stamps of it, and which views heard it.

    The stamps are the newest echo's and that of the echo from which on there were `enough`.

    Args:
        views: All views.
        order: Their rows, the newest first.
        axis: The line's theta (rad) and rho (m), and of its bins the first's start and length, m.
        num: How many there are.
        tolerance: Of a range, m.
        share: Of a range beside, in shares of it.
        enough: Open echoes.
    """
    theta, rho, first, step = axis
    c, s = np.cos(theta), np.sin(theta)
    echoes, weak = np.zeros(num), np.zeros(num)
    newest, since = np.zeros(num, np.int64), np.zeros(num, np.int64)
    is_on = np.zeros(len(views), np.bool_)
    for i in order:
        view = views[i]
        a, b = _spot(c * view.y - s * view.x, first, step, num)
        fit = lies_on(view, theta, c, s, rho, tolerance, share) if a < b else 0
        is_on[i] = fit > 0
        for k in range(a, b) if fit > 0 else range(0):
            newest[k] = max(newest[k], view.stamp_ns)
            if fit == 1:
                weak[k] += view.weight
                continue
            if echoes[k] < enough <= echoes[k] + view.weight:
                since[k] = view.stamp_ns
            echoes[k] += view.weight
    return echoes, weak, newest, since, is_on


@numba.njit(cache=True, nogil=True)
def missing(  # type: ignore[no-untyped-def]
    views, order, axis, newest, since, is_on, sure, trusted
):
    """Return how often every bin was faced and not heard, and how often since its newest echo.

    Misses from farther than `trusted` together count as one at most: glass that answers weakly
    answers none of them.

    Args:
        views: All views.
        order: Their rows, the oldest first.
        axis: See `heard`.
        newest: Stamp of each bin's newest echo, ns.
        since: Stamp that each bin's misses count from, ns.
        is_on: Which views heard the line.
        sure: Glass that is met within this of its normal answers for sure, rad.
        trusted: See above, m.
    """
    theta, rho, first, step = axis
    c, s, num = np.cos(theta), np.sin(theta), len(newest)
    missed, newer, far, far_newer = np.zeros(num), np.zeros(num), np.zeros(num), np.zeros(num)
    last = order[0] if len(order) else 0
    for i in order:
        view = views[i]
        along, d = c * view.y - s * view.x, rho - (c * view.x + s * view.y)
        crossing, has_crossed = _crossing(views[last], view, c, s, rho)
        has_crossed &= not (is_on[i] or is_on[last])
        last = i
        if has_crossed:
            a, b = _spot(crossing, first, step, num)
            _count(missed, newer, newest, since, a, b, WENT_THROUGH, view.stamp_ns)
        if abs(d) < TOO_NEAR_M or view.r <= abs(d) + FREE_BEYOND_M:
            continue
        low, high = _faced(view, theta, along, d, sure)
        a = max(int(np.ceil((low - first) / step - 0.5)), 0)
        b = min(int(np.floor((high - first) / step - 0.5)) + 1, num)
        if abs(d) <= trusted:
            _count(missed, newer, newest, since, a, b, view.weight, view.stamp_ns)
        else:
            lost = view.weight * (trusted / d) ** 2  # as G of eq. 1
            _count(far, far_newer, newest, since, a, b, lost, view.stamp_ns)
    return missed + np.minimum(far, 1.0), newer + np.minimum(far_newer, 1.0)


@numba.njit(cache=True, inline="always")
def _count(missed, newer, newest, since, a, b, lost, stamp_ns):  # type: ignore[no-untyped-def]
    """Add a miss to the bins from a to b."""
    for k in range(a, b):
        if stamp_ns >= since[k]:
            missed[k] += lost
            newer[k] += lost if stamp_ns > newest[k] else 0.0


@numba.njit(cache=True, inline="always")
def _crossing(before, after, c, s, rho):  # type: ignore[no-untyped-def]
    """Return where along a line the way between two views crosses it, and whether it does."""
    d0 = rho - (c * before.x + s * before.y)
    d1 = rho - (c * after.x + s * after.y)
    is_way = np.hypot(after.x - before.x, after.y - before.y) <= STEP_M
    if (d0 > 0.0) == (d1 > 0.0) or not is_way or after.stamp_ns - before.stamp_ns > STEP_NS:
        return 0.0, False
    share = d0 / (d0 - d1)
    x, y = before.x + share * (after.x - before.x), before.y + share * (after.y - before.y)
    return c * y - s * x, True


@numba.njit(cache=True, inline="always")
def _faced(view, theta, along, d, sure):  # type: ignore[no-untyped-def]
    """Return from where to where a cone met a line so squarely that glass had answered, m."""
    off = wrapped(view.yaw - theta if d > 0.0 else view.yaw - theta - np.pi)
    low = max(off - view.half + EDGE_RAD, -sure)
    high = min(off + view.half - EDGE_RAD, sure)
    if high <= low:
        return 0.0, -1.0
    if d > 0.0:
        return along + d * np.tan(low), along + d * np.tan(high)
    return along + d * np.tan(high), along + d * np.tan(low)


@numba.njit(cache=True, nogil=True)
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
