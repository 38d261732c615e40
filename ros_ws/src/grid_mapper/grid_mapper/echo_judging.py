"""What an echo says of glass, given what the laser saw and what was heard from near by.

An echo at r tells that somewhere on the arc at r within the cone a surface faces the sonar. Where
the laser sees something opaque at that range in the cone, the echo is explained. Behind what is
opaque nothing can be heard: an echo from there came by way of mirrors. On what is left of the arc
there may be glass: a plane, and so the line at distance r from each of the places that it was heard
from. The normal of that line is the direction that most other echoes of the neighborhood agree on.
"""

from __future__ import annotations

import numba
import numpy as np

from grid_mapper.opaque_cells import at
from grid_mapper.sonar_views import END

NUM_RAYS = 21
"""Directions that a cone is divided into: 1 degree apart in one of 20 degrees."""
EDGE_RAD = 0.01
"""How far beyond a cone's edge a normal may lie, for noise of the yaw."""


@numba.njit(cache=True, inline="always")
def wrapped(angle):  # type: ignore[no-untyped-def]
    """Return the angle in [-pi, pi)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@numba.njit(cache=True)
def opaque_at(cells, x, y, angle, far):  # type: ignore[no-untyped-def]
    """Return the distance of the first opaque cell on a ray, m; inf for none.

    Args:
        cells: See `opaque_cells.Cells`.
        x: Of the start of the ray, m.
        y: Of the start, m.
        angle: Its direction, rad.
        far: Where to stop, m.
    """
    ux, uy, step = np.cos(angle), np.sin(angle), 0.5 * cells.resolution
    for k in range(int(far / step) + 1):
        t = k * step
        if at(cells, x + t * ux, y + t * uy)[0] > 0.0:
            return t
    return np.inf


@numba.njit(cache=True)
def open_rays(view, explained, cells):  # type: ignore[no-untyped-def]
    """Return the directions in which glass may have answered, a bit for each of `NUM_RAYS`.

    Args:
        view: An echo, see `sonar_views`.
        explained: How near the echo opaque things explain it, m.
        cells: See `opaque_cells.Cells`.
    """
    rays = np.int64(0)
    for k in range(NUM_RAYS):
        angle = view.yaw + view.half * (2.0 * k / (NUM_RAYS - 1) - 1.0)
        t = opaque_at(cells, view.x, view.y, angle, view.r + explained)
        if t >= view.r - explained and t < np.inf:
            return np.int64(0)
        if t == np.inf:
            rays |= np.int64(1) << k
    return rays


@numba.njit(cache=True)
def best_normal(views, i, firsts, tolerance, share):  # type: ignore[no-untyped-def]
    """Return the direction on view i's open arc that most echoes near by agree on, and how many.

    Two echoes agree on a line when both their places lie at their ranges from it, and its normal
    lies in both their cones.

    Args:
        views: All views.
        i: Row of the echo.
        firsts: First rows of the cells to look in.
        tolerance: Of ranges, m.
        share: Of ranges beside, in shares of them.
    """
    me = views[i]
    scores = np.zeros(NUM_RAYS)
    for first in firsts:
        j = first
        while j != END:
            you = views[j]
            is_other = j != i and you.is_echo and you.open != 0
            if is_other and abs(wrapped(you.yaw - me.yaw)) <= me.half + you.half:
                _vote(scores, me, you, tolerance + share * me.r)
            j = you.next
    best = 0
    for k in range(NUM_RAYS):
        if scores[k] > scores[best]:
            best = k
    return me.yaw + me.half * (2.0 * best / (NUM_RAYS - 1) - 1.0), scores[best]


@numba.njit(cache=True, inline="always")
def _vote(scores, me, you, tolerance):  # type: ignore[no-untyped-def]
    """Add to the score of every direction in which both echoes lie on one line."""
    dx, dy, dr = you.x - me.x, you.y - me.y, you.r - me.r
    if abs(dr) > np.sqrt(dx * dx + dy * dy) + tolerance:
        return
    for k in range(NUM_RAYS):
        if not (me.open >> k) & 1:
            continue
        theta = me.yaw + me.half * (2.0 * k / (NUM_RAYS - 1) - 1.0)
        error = abs(np.cos(theta) * dx + np.sin(theta) * dy + dr)
        if error < tolerance and abs(wrapped(theta - you.yaw)) <= you.half + EDGE_RAD:
            scores[k] += you.weight * (1.0 - (error / tolerance) ** 2)


@numba.njit(cache=True)
def judge(views, rows, firsts, explained, tolerance, share, cells):  # type: ignore[no-untyped-def]
    """Judge views anew, in place: their open rays, best normal and its score.

    Args:
        views: All views.
        rows: Which to judge, shape (N,).
        firsts: For each the cells to look in, shape (N, 9).
        explained: See `open_rays`.
        tolerance: See `best_normal`.
        share: See `best_normal`.
        cells: See `opaque_cells.Cells`.
    """
    for n in range(len(rows)):
        i = rows[n]
        if not views[i].is_echo:
            continue
        views[i].open = open_rays(views[i], explained, cells)
        if views[i].open == 0:
            views[i].score = 0.0
            continue
        views[i].theta, views[i].score = best_normal(views, i, firsts[n], tolerance, share)


@numba.njit(cache=True, nogil=True)
def judge_aside(  # type: ignore[no-untyped-def]
    views, rows, firsts, explained, tolerance, share, cells
):
    """Do as `judge` and let other threads run meanwhile, which costs a turn each time."""
    judge(views, rows, firsts, explained, tolerance, share, cells)
