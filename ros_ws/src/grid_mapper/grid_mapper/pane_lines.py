"""Lines of panes, fitted to echoes from many places.

A pane is flat: the echoes that it sent to sonars on its way all lie at their ranges from one line,
from either side. A line is grown from the echo that most others agree with, fitted by least squares
to all that lie on it without a gap, and its echoes are taken; then the next one is grown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from grid_mapper.bayes_config import BayesConfig
from grid_mapper.echo_judging import EDGE_RAD, NUM_RAYS, wrapped

STIFF = 1e-3
"""Information that holds a line where its echoes leave it undetermined."""


@dataclass(frozen=True)
class PaneLine:
    """The line x cos(theta) + y sin(theta) = rho, and what lies on it.

    Attributes:
        theta: Direction of its normal, rad.
        rho: Its distance from the map's origin along the normal, m.
        echoes: Rows of its echoes, shape (N,).
        low: Where its first echo lies along (-sin(theta), cos(theta)), m.
        high: Where its last one lies.
        range: Mean range of its echoes, m.
    """

    theta: float
    rho: float
    echoes: np.ndarray
    low: float
    high: float
    range: float


def find_lines(views: np.ndarray, config: BayesConfig) -> list[PaneLine]:
    """Return the lines that echoes without other cause lie on, the best supported first.

    Args:
        views: Judged views, see `echo_judging.judge`.
        config: Its `seed_views`, `pane_*`, `range_tolerance_*` and `max_bay_m` are used.
    """
    is_taken = ~views["is_echo"] | (views["open"] == 0)
    seeds = np.flatnonzero(~is_taken & (views["score"] >= config.seed_views))
    seeds = seeds[np.argsort(-views["score"][seeds], kind="stable")]
    tolerance = config.range_tolerance_m, config.range_tolerance_share
    gaps = np.array([0.5, 0.5 + 0.5 * config.max_bay_m, config.max_bay_m, config.max_bay_m])
    lines = []
    for seed in seeds:
        if is_taken[seed]:
            continue
        theta, rho, rows = grow(views, is_taken, seed, *tolerance, gaps)
        mine = views[rows]
        if not is_supported(mine, config):
            is_taken[seed] = True
            continue
        along = along_line(mine, theta)
        line = PaneLine(
            theta, rho, rows, float(along.min()), float(along.max()), float(mine["r"].mean())
        )
        lines.append(line)
        take_explained(
            views, is_taken, theta, rho, line.low, line.high, *tolerance, config.critical_rad
        )
        is_taken[rows] = True
    return lines


def is_supported(echoes: np.ndarray, config: BayesConfig) -> bool:
    """Tell whether so many echoes, from places so far apart, make a pane."""
    if not len(echoes):
        return False
    trust = np.minimum((config.trusted_m / echoes["r"]) ** 2, 1.0)  # as G of eq. 1
    is_heard = float(echoes["weight"] @ trust) >= config.pane_views
    return is_heard and _spread(echoes) >= config.pane_baseline_m


def along_line(views: np.ndarray, theta: float) -> np.ndarray:
    """Return where views are along (-sin(theta), cos(theta)), m."""
    return np.asarray(np.cos(theta) * views["y"] - np.sin(theta) * views["x"])


def _spread(views: np.ndarray) -> float:
    """Return how far apart the places of views are, m."""
    return float(np.hypot(np.ptp(views["x"]), np.ptp(views["y"])))


@numba.njit(cache=True, inline="always")
def lies_on(view, theta, c, s, rho, tolerance, share):  # type: ignore[no-untyped-def]
    """Tell how an echo fits a line, from either side: 0 not, 1 but it is explained, 2 open."""
    if not view.is_echo:
        return 0
    d = rho - (c * view.x + s * view.y)
    if abs(abs(d) - view.r) > tolerance + share * view.r:
        return 0
    off = wrapped(theta - view.yaw if d > 0.0 else theta + np.pi - view.yaw)
    if abs(off) > view.half + EDGE_RAD:
        return 0
    k = int(np.rint((off / view.half + 1.0) * 0.5 * (NUM_RAYS - 1)))
    return 2 if (view.open >> min(max(k, 0), NUM_RAYS - 1)) & 1 else int(view.open == 0)


@numba.njit(cache=True, nogil=True)
def grow(views, is_taken, seed, tolerance, share, gaps):  # type: ignore[no-untyped-def]
    """Return normal, distance and echoes of the line grown from the best normal of one echo."""
    me = views[seed]
    theta = me.theta
    rho = np.cos(theta) * me.x + np.sin(theta) * me.y + me.r
    rows = np.empty(0, np.int64)
    for gap in gaps:
        c, s = np.cos(theta), np.sin(theta)
        rows = _on_line(views, is_taken, theta, c, s, rho, tolerance, share)
        rows = _run_about(views, rows, c, s, c * me.y - s * me.x, gap)
        if len(rows) < 2:
            break
        theta, rho = fit_line(views, rows, theta, rho, c * me.y - s * me.x)
    return theta, rho, rows


@numba.njit(cache=True)
def _on_line(views, is_taken, theta, c, s, rho, tolerance, share):  # type: ignore[no-untyped-def]
    rows = np.empty(len(views), np.int64)
    num = 0
    for i in range(len(views)):
        if not is_taken[i] and lies_on(views[i], theta, c, s, rho, tolerance, share) == 2:
            rows[num] = i
            num += 1
    return rows[:num]


@numba.njit(cache=True)
def _run_about(views, rows, c, s, middle, gap):  # type: ignore[no-untyped-def]
    """Return those rows that are joined to the place `middle` without a longer gap."""
    along = np.empty(len(rows))
    for n in range(len(rows)):
        along[n] = c * views[rows[n]].y - s * views[rows[n]].x
    order = np.argsort(along, kind="mergesort")
    first, last = 0, len(rows)
    for n in range(1, len(rows)):
        before, after = along[order[n - 1]], along[order[n]]
        if after - before > gap and after - middle <= middle - before:
            first = n
        elif after - before > gap:
            last = n
            break
    return rows[order[first:last]]


@numba.njit(cache=True)
def fit_line(views, rows, theta, rho, middle):  # type: ignore[no-untyped-def]
    """Return the line nearest to echoes in the least squares of range, from a first guess.

    An echo at r from place p lies on the line n . p + r = rho, or n . p - r = rho from behind. The
    line turns about its point at `middle`, which keeps the two unknowns apart.
    """
    c, s = np.cos(theta), np.sin(theta)
    a11, a12, a22, b1, b2 = STIFF, 0.0, STIFF, 0.0, 0.0
    for i in rows:
        view = views[i]
        d = rho - (c * view.x + s * view.y)
        error = (d - view.r) if d > 0.0 else (d + view.r)
        arm = c * view.y - s * view.x - middle
        w = view.weight
        a11, a12, a22 = a11 + w, a12 - w * arm, a22 + w * arm * arm
        b1, b2 = b1 - w * error, b2 + w * error * arm
    det = a11 * a22 - a12 * a12
    shift, turn = (a22 * b1 - a12 * b2) / det, (a11 * b2 - a12 * b1) / det
    # the point at `middle` on the old line, moved by `shift`, stays on the turned one
    x, y = (rho + shift) * c - middle * s, (rho + shift) * s + middle * c
    theta = theta + turn
    return theta, np.cos(theta) * x + np.sin(theta) * y


@numba.njit(cache=True, nogil=True)
def take_explained(  # type: ignore[no-untyped-def]
    views, is_taken, theta, rho, low, high, tolerance, share, critical
):
    """Take the echoes that a pane explains, also those from its part at a cone's edge."""
    c, s = np.cos(theta), np.sin(theta)
    for i in range(len(views)):
        view = views[i]
        if is_taken[i]:
            continue
        d = rho - (c * view.x + s * view.y)
        off = wrapped(theta - view.yaw if d > 0.0 else theta + np.pi - view.yaw)
        slant = max(abs(off) - view.half, 0.0)
        if slant > critical or abs(abs(d) / np.cos(slant) - view.r) > 2.0 * (
            tolerance + share * view.r
        ):
            continue
        side = np.sign(off) if d > 0.0 else -np.sign(off)
        along = c * view.y - s * view.x - side * abs(d) * np.tan(slant)
        if low - 0.3 < along < high + 0.3:
            is_taken[i] = True
