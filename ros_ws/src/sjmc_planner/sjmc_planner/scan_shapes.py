"""Where the things of a scan have their middles, taken for upright round bodies.

The edges of a round body are seen along its tangents: with half the angle between them a and its
nearest range r, its middle is at r / (1 - sin a) and its radius r sin a / (1 - sin a). An edge that
something nearer hides is not its own: the middle is then found from the other edge and the radius
that a body has at least.
"""

from __future__ import annotations

import numba
import numpy as np

X, Y, HALF, WIDTH, BEAMS, RANGE, HIDDEN = range(7)
NUM_COLUMNS = 7
_WIDEST = 0.45  # radius that is still believed, m
_NEARER = 0.10  # what hides an edge is nearer by more than this, m


@numba.njit(cache=True, nogil=True)
def shapes_of(  # type: ignore[no-untyped-def]
    ranges, ends, num_things, angle_min, increment, sensor, widest, radius, shapes, things
):
    """Write the middle of each thing up to a width.

    Args:
        ranges: Shape (N,), m.
        ends: From `cluster_beams`.
        num_things: From `cluster_beams`.
        angle_min: Bearing of the first beam, rad.
        increment: From beam to beam, rad.
        sensor: x, y, yaw of the sensor in the frame of the result.
        widest: Wider things are left out, m.
        radius: Of a body whose edge is hidden, at least, m.
        shapes: Output: the columns above of each that is left, shape (N, NUM_COLUMNS).
        things: Output: which thing each row is, shape (N,).

    Returns:
        The number of rows.
    """
    num, rows = len(ranges), 0
    for thing in range(num_things):
        a, b, beams = ends[thing, 0], ends[thing, 1], ends[thing, 2]
        if beams < 2:
            continue
        spread = ((b - a) % num) * abs(increment)
        ra, rb = ranges[a], ranges[b]
        width = np.sqrt((ra - rb) ** 2 + 4.0 * ra * rb * np.sin(0.5 * min(spread, np.pi)) ** 2)
        if width > widest:
            continue
        is_first_hidden = _is_hidden(ranges, a, -1)
        is_last_hidden = _is_hidden(ranges, b, 1)
        nearest = _nearest(ranges, a, b)
        half = 0.5 * (spread + abs(increment))  # an edge lies between two beams
        middle = angle_min + increment * a + 0.5 * np.sign(increment) * spread
        if is_first_hidden != is_last_hidden:
            more = max(np.arcsin(radius / (radius + nearest)) - half, 0.0)
            middle += np.sign(increment) * (-more if is_first_hidden else more)
            half += more
        sine = min(np.sin(min(half, 0.5 * np.pi)), 0.9)
        own = min(nearest * sine / (1.0 - sine), _WIDEST)
        r = nearest + own
        shapes[rows, X] = sensor[0] + r * np.cos(sensor[2] + middle)
        shapes[rows, Y] = sensor[1] + r * np.sin(sensor[2] + middle)
        shapes[rows, HALF], shapes[rows, WIDTH] = own, width
        shapes[rows, BEAMS], shapes[rows, RANGE] = beams, nearest
        shapes[rows, HIDDEN] = 1.0 if is_first_hidden or is_last_hidden else 0.0
        things[rows] = thing
        rows += 1
    return rows


@numba.njit(cache=True, nogil=True)
def _is_hidden(ranges, i, way):  # type: ignore[no-untyped-def]
    """Tell whether what is seen beside an edge is nearer, so that it may hide more."""
    num = len(ranges)
    for k in range(1, 3):
        beside = ranges[(i + way * k) % num]
        if beside < ranges[i] - _NEARER and beside > 0.0:
            return True
    return False


@numba.njit(cache=True, nogil=True)
def _nearest(ranges, a, b):  # type: ignore[no-untyped-def]
    """Return the range of the thing's front: the mean of its middle third."""
    num = len(ranges)
    spread = (b - a) % num
    total, count = 0.0, 0
    for k in range(spread // 3, spread - spread // 3 + 1):
        r = ranges[(a + k) % num]
        if r > 0.0 and np.isfinite(r):
            total, count = total + r, count + 1
    return total / count if count else ranges[a]
