"""What a sensor did not see, along the bearings of the base: blind sectors and shadows.

A place is known only if a beam of the sensor passed over it: the beam that covers its bearing from
the sensor was looked along (not NaN), and ended no nearer. Seen from a sensor that is not at the
robot's middle, such places begin somewhere along a bearing of the base, and bearings that no beam
has may be seen farther out: what counts is the first unseen place outside of the robot's own
circle. A line is walked from beam to beam; each beam's part of it is a straight piece whose
distance from the sensor has one minimum, so its first place beyond the beam's end is a root of a
quadratic.
"""

from __future__ import annotations

import numba
import numpy as np

from floornav_common.se2 import SE2

_TURN = 2.0 * np.pi
_SAME = 1e-9
_AWRY = 1e-5  # so that no line runs through the sensor, where its bearing turns over, rad


def unseen_table(
    start: np.ndarray, width: np.ndarray, ranges: np.ndarray, T_base_sensor: SE2, radius: float,
    num: int,
) -> np.ndarray:  # fmt: skip
    """Return how far the robot's middle gets until its front is at something unseen.

    Args:
        start: Right side of each wedge of the scan, from the sensor, shape (M,), rad; together
            the wedges go once around.
        width: How far it reaches to the left, shape (M,), rad.
        ranges: Where what it sees ends, shape (M,), m; inf for nowhere, NaN if not looked.
        T_base_sensor: The sensor.
        radius: Of the robot's own circle, m.
        num: Entries of the table, at the bearings 2 pi k / num of the base.

    Returns:
        Shape (num,), m; inf where all is seen. Each entry is the least of its middle and sides.
    """
    first = np.remainder(start, _TURN)
    order = np.argsort(first)
    T = T_base_sensor.inverse()
    half_steps = np.pi / num * np.arange(2 * num) + (T.yaw + _AWRY)
    units = np.column_stack((np.cos(half_steps), np.sin(half_steps)))
    origin = np.array([T.x, T.y])
    fine = first_unseen(first[order], width[order], ranges[order], origin, units, radius)
    entries = np.minimum(fine[0::2], np.minimum(fine[1::2], np.roll(fine[1::2], 1)))
    return np.maximum(entries - radius, 0.0)


@numba.njit(cache=True, nogil=True)
def first_unseen(start, width, ranges, origin, units, begin):  # type: ignore[no-untyped-def]
    """Return how far along each line the first unseen place is.

    Args:
        start: Right sides of the wedges in rising order, in [0, 2 pi), shape (M,), rad.
        width: Of the wedges, shape (M,), rad.
        ranges: As for `unseen_table`, shape (M,), m.
        origin: Where all lines begin, in the sensor's frame, shape (2,), m.
        units: Their directions, in the sensor's frame, shape (K, 2).
        begin: Nearer than this nothing counts, m.
    """
    num = len(start)
    found = np.full(len(units), np.inf)
    for k in range(len(units)):
        ux, uy = units[k, 0], units[k, 1]
        x, y = origin[0] + begin * ux, origin[1] + begin * uy
        turn = x * uy - y * ux  # which way the line turns about the sensor
        is_radial = abs(turn) < _SAME
        bearing = np.arctan2(uy, ux) if is_radial else np.arctan2(y, x)
        i = (np.searchsorted(start, bearing % _TURN, side="right") - 1) % num
        r = begin
        for _ in range(num + 1):
            leaves = np.inf
            if not is_radial:
                side = start[i] + width[i] if turn > 0.0 else start[i]
                leaves = _crossing(origin, ux, uy, np.cos(side), np.sin(side), r)
            end = ranges[i]
            if np.isnan(end):
                found[k] = r
            elif end != np.inf:
                out = _beyond(origin, ux, uy, end, r)
                if out <= leaves:
                    found[k] = out
            if found[k] != np.inf or leaves == np.inf:
                break
            r = leaves
            i = (i + 1) % num if turn > 0.0 else (i - 1) % num
    return found


@numba.njit(cache=True, nogil=True, inline="always")
def _crossing(origin, ux, uy, cx, cy, least):  # type: ignore[no-untyped-def]
    """Return how far along a line it crosses a ray from the sensor; inf if it does not."""
    across = ux * cy - uy * cx
    if abs(across) < 1e-12:
        return np.inf
    r = -(origin[0] * cy - origin[1] * cx) / across
    along = (origin[0] + r * ux) * cx + (origin[1] + r * uy) * cy
    return max(r, least) if along > 0.0 and r > least - _SAME else np.inf


@numba.njit(cache=True, nogil=True, inline="always")
def _beyond(origin, ux, uy, end, least):  # type: ignore[no-untyped-def]
    """Return how far along a line, from `least` on, it is first farther than `end`."""
    half = origin[0] * ux + origin[1] * uy
    rest = origin[0] * origin[0] + origin[1] * origin[1] - end * end
    if least * least + 2.0 * half * least + rest >= 0.0:
        return least
    return -half + np.sqrt(max(half * half - rest, 0.0))
