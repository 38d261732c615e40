"""Obstacles grown by the robot's radius, as a table of distances over bearings (paper, Fig. 5).

Each beam that hit something stands for a wedge: the obstacle fills the beam's width from its range
outwards. With the robot shrunk to its middle, the wedge grows by its radius R. Seen along a bearing
that misses the wedge by the angle d, it begins where the circle about the wedge's corner does, at
r cos d - sqrt(R^2 - (r sin d)^2); the wedge's sides never reach nearer. Each entry of the table
holds the least of that over its own width, so that nothing slips between two entries.

An obstacle nearer than R already counts as touching: it closes the half plane towards it and no
more, so that the robot may go away.

What is not known: a beam of `+inf` is free to `range_max` and unknown beyond; one of `-inf`, or
below `range_min`, may be anywhere nearer and counts as touching. NaN and bearings that no beam
covers were not seen. A narrow gap of those takes the nearer range beside it (a laser's dropouts, a
mirror's stay). A wider one, and what an obstacle hides from a sensor that is not at the robot's
middle, is closed: the robot's front never gets there (`unseen`); but it is not grown aside, or a
robot with a blind rear could not move sideways either.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.planning import Obstacles
from sjmc_planner.unseen import unseen_table

_TOUCHING = 0.9999  # of an obstacle's distance: the most it is grown by
_TURN = 2.0 * np.pi
_ACROSS = np.linspace(0.0, 1.0, 5)  # where over a wedge's width its corners are taken
_PARTS = 6  # along a beam that may end anywhere
_TIP = 0.01  # its length if the sensor names none, m


@dataclass(frozen=True)
class Wedges:
    """What a scan says, seen from the sensor; together the wedges go once around.

    Attributes:
        start: Bearing of each wedge's right side, shape (M,), rad.
        width: How far it reaches to the left, shape (M,), rad.
        ranges: Where its obstacle begins, shape (M,), m; inf if none was seen, 0 if it may be
            anywhere nearer than `blind`, NaN if it was not looked.
        horizon: How far was looked, m.
        blind: Nearer than this the sensor sees nothing, m.
        T_base_sensor: The sensor.
    """

    start: np.ndarray
    width: np.ndarray
    ranges: np.ndarray
    horizon: float
    blind: float = 0.0
    T_base_sensor: SE2 = SE2(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class GrownSpace:
    """Where the robot's middle may be.

    Attributes:
        seen: Distance to what was seen, r_o(phi) at the bearings 2 pi k / N, shape (N,), m; inf
            where nothing was, and no farther than to what was not looked at.
        known: The same, and no farther than the robot stays within the horizon.
    """

    seen: np.ndarray
    known: np.ndarray

    def border(self) -> np.ndarray:
        """Return the points of `seen`, shape (N, 2), m; NaN where nothing was."""
        bearings = _TURN * np.arange(len(self.seen)) / len(self.seen)
        r = np.where(np.isfinite(self.seen), self.seen, np.nan)
        return np.column_stack((r * np.cos(bearings), r * np.sin(bearings)))


def wedges_of(obstacles: Obstacles, unseen_gap: float) -> Wedges:
    """Return the wedges of a scan.

    Args:
        obstacles: The scan and where its sensor is.
        unseen_gap: Gaps up to this take the nearer range beside them, rad.
    """
    scan = obstacles.scan
    step = abs(scan.angle_increment)
    ranges = _filled(_effective_ranges(scan), step, unseen_gap)
    start, width = scan.angles - 0.5 * step, np.full(len(ranges), step)
    gap = _TURN - step * len(ranges)
    if gap > 1e-6:
        start = np.append(start, start.max() + step)
        width = np.append(width, gap)
        between = np.fmin(ranges[0], ranges[-1]) if gap <= unseen_gap else np.nan
        ranges = np.append(ranges, between)
    return Wedges(start, width, ranges, scan.range_max, scan.range_min, obstacles.T_base_sensor)


def grow(wedges: Wedges, radius: float, num: int) -> GrownSpace:
    """Return the table of distances to obstacles grown by a radius.

    Args:
        wedges: What was seen.
        radius: Of the robot, m.
        num: Entries of the table (N).
    """
    T = wedges.T_base_sensor
    seen = grow_table(*_from_base(wedges, radius), radius, num)
    unseen = unseen_table(wedges.start, wedges.width, wedges.ranges, T, radius, num)
    seen = np.minimum(seen, unseen)
    return GrownSpace(seen, np.minimum(seen, max(wedges.horizon - T.distance - radius, 0.0)))


@numba.njit(cache=True, nogil=True)
def grow_table(start, width, ranges, radius, num):  # type: ignore[no-untyped-def]
    """Return r_o over `num` bearings of wedges seen from the robot's middle; see `grow`."""
    step = 2.0 * np.pi / num
    table = np.full(num, np.inf)
    for i in range(len(ranges)):
        r = max(ranges[i], radius)
        R = min(radius, _TOUCHING * r)
        reach = np.arcsin(R / r)
        end = start[i] + width[i]
        first = int(np.ceil((start[i] - reach) / step - 0.5))
        last = int(np.floor((end + reach) / step + 0.5))
        for k in range(first, min(last, first + num - 1) + 1):
            entry = k % num
            if table[entry] <= r - R:
                continue
            bearing = k * step
            d = max(start[i] - bearing, bearing - end) - 0.5 * step
            if d <= 0.0:
                table[entry] = r - R
                continue
            across = r * np.sin(min(d, reach))
            along = np.sqrt(max(r * r - across * across, 0.0))
            table[entry] = min(table[entry], along - np.sqrt(max(R * R - across * across, 0.0)))
    return table


def _effective_ranges(scan: Scan) -> np.ndarray:
    """Return where obstacles begin: inf for nowhere, 0 for anywhere, NaN if it was not looked."""
    r = np.asarray(scan.ranges, dtype=float)
    with np.errstate(invalid="ignore"):
        r = np.where(r > scan.range_max, np.inf, r)
        # Drivers write 0 for "no return" too: not a measurement (REP 117 has -inf for too near).
        r = np.where((r == 0.0) & (scan.range_min > 0.0), np.nan, r)
        return np.where(r < scan.range_min, 0.0, r)


def _filled(ranges: np.ndarray, step: float, unseen_gap: float) -> np.ndarray:
    """Return the ranges with narrow gaps of NaN closed by the nearer range beside them."""
    is_unseen = np.isnan(ranges)
    if not is_unseen.any() or is_unseen.all():
        return ranges
    is_round = step * len(ranges) > _TURN - 1e-6
    filled = ranges.copy()
    edges = np.flatnonzero(np.diff(np.concatenate(([False], is_unseen, [False]))))
    runs = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
    if is_round and len(runs) > 1 and runs[0][0] == 0 and runs[-1][1] == len(ranges):
        runs[0] = (runs.pop()[0] - len(ranges), runs[0][1])
    for a, b in runs:
        if (b - a) * step > unseen_gap + 1e-9:
            continue
        right = ranges[a - 1] if a > 0 or is_round else np.nan
        left = ranges[b % len(ranges)] if b < len(ranges) or is_round else np.nan
        filled[np.arange(a, b)] = np.fmin(right, left)
    return filled


def _from_base(wedges: Wedges, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the obstacles as wedges seen from the robot's middle: start, width, ranges.

    Of one that may be anywhere nearer than the sensor sees, what counts is the part outside of the
    robot's circle; it touches if any of it may be inside.
    """
    is_near, is_hit = wedges.ranges == 0.0, np.isfinite(wedges.ranges)
    blind = max(wedges.blind, _TIP)
    tips = np.where(is_near, blind, wedges.ranges)[is_hit]
    is_near = is_near[is_hit]
    num_parts = _PARTS if is_near.any() else 1  # of most scans, only the end of each wedge counts
    share = np.where(is_near[:, None], np.linspace(0.0, 1.0, num_parts), 1.0)
    angles = wedges.start[is_hit, None] + wedges.width[is_hit, None] * _ACROSS
    r = tips[:, None, None] * share[:, :, None]
    corners = np.stack((r * np.cos(angles)[:, None], r * np.sin(angles)[:, None]), axis=-1)
    x, y = (wedges.T_base_sensor @ corners.reshape(-1, 2)).reshape(*corners.shape).T
    distances = np.hypot(x, y).transpose(2, 1, 0)  # shape (M, parts, across)
    bearings = np.arctan2(y, x).transpose(2, 1, 0)
    middle = bearings[:, -1, len(_ACROSS) // 2]
    off = np.remainder(bearings - middle[:, None, None] + np.pi, _TURN) - np.pi
    counts = ~is_near[:, None, None] | (distances > radius)
    counts[:, -1] = True
    least = np.where(counts, off, np.inf).min(axis=(1, 2))
    most = np.where(counts, off, -np.inf).max(axis=(1, 2))
    nearest = distances.min(axis=(1, 2))
    return middle + least, most - least, np.where(is_near & (nearest < radius), 0.0, nearest)
