"""Where earlier scans saw free space: what stands there now has moved.

A wall that slides into view, the corner of a cupboard, a piece of wall seen through a door: as the
robot drives, the middles of such things move over the ground though they do not. But they never
stand where a beam has passed a moment ago. So each scan is kept for a second, with the pose it was
taken from, and an end of the newest scan is held against those: it counts as free if any of them
saw beyond it along its bearing, and as known if one saw something right there. Who walks straight
away has only ever hidden the place where they are now; but where something stood in front of it,
the newest scan sees beyond: that is left.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from floornav_common.scan import Scan
from sjmc_planner.free_times import _bearing

# numba keeps these kernels by this file's date alone: one that changes `_bearing` has to change
# this file too, or a kernel with the old one goes on being used.
_NUM_KEPT = 5
_APART_S = 0.18
_SLACK_RAD = 0.012  # errors of bearing
_MARGIN = 0.10  # errors of range and of odometry, m
_MARGIN_SHARE = 0.015  # of the range
_POINTS = 9  # along a thing
_LEFT_BEHIND = 1.0  # what stood farther before an end is another thing, m
FREE, KNOWN, LEFT = 0, 1, 2
_NEWEST_S = 0.15  # what is newer shows no motion yet


class SeenFree:
    """The scans of the last second.

    Attributes:
        free: How far each beam of each was free, and so were those beside it, shape (K, N), m.
        ends: Where each beam of each ended, shape (K, N), m.
        poses: x, y, yaw of the sensor, shape (K, 3).
        ages: Since each was taken, shape (K,), s; inf for none.
        beams: `angle_min` and `angle_increment` of all of them.
    """

    def __init__(self) -> None:
        self.free, self.ends = np.zeros((_NUM_KEPT, 0)), np.zeros((_NUM_KEPT, 0))
        self.poses = np.zeros((_NUM_KEPT, 3))
        self.ages = np.full(_NUM_KEPT, np.inf)
        self.beams = (0.0, 1.0)

    def age(self, dt: float) -> None:
        """Let time pass."""
        self.ages += dt

    def keep(self, scan: Scan, ranges: np.ndarray, sensor: np.ndarray) -> None:
        """Keep a scan unless one was kept a moment ago.

        Args:
            scan: The scan.
            ranges: Of it, as float64.
            sensor: x, y, yaw of the sensor in the frame that all poses are in.
        """
        if len(ranges) != self.free.shape[1] or self.beams != (
            scan.angle_min,
            scan.angle_increment,
        ):
            self.free = np.zeros((_NUM_KEPT, len(ranges)))
            self.ends = np.zeros((_NUM_KEPT, len(ranges)))
            self.ages = np.full(_NUM_KEPT, np.inf)
            self.beams = (scan.angle_min, scan.angle_increment)
        if self.ages.min() < _APART_S - 1e-9:
            return
        oldest = int(np.argmax(self.ages))
        reach = math.ceil(_SLACK_RAD / abs(scan.angle_increment))
        _free_ranges(ranges, scan.range_min, scan.range_max, reach, self.free[oldest])
        self.ends[oldest] = ranges
        self.poses[oldest], self.ages[oldest] = sensor, 0.0

    def kept(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float, float]:
        """Return what `told_of` takes."""
        return self.free, self.ends, self.poses, self.ages, *self.beams


@numba.njit(cache=True, nogil=True)
def _free_ranges(ranges, range_min, range_max, reach, free):  # type: ignore[no-untyped-def]
    """Write the least of each beam's range and those beside it; 0 where one was not measured."""
    num = len(ranges)
    own = np.empty(num)
    for i in range(num):
        r = ranges[i]
        own[i] = min(r, range_max) if r >= range_min else 0.0
    for i in range(num):
        least = own[i]
        for k in range(max(i - reach, 0), min(i + reach, num - 1) + 1):
            least = min(least, own[k])
        free[i] = least


@numba.njit(cache=True, nogil=True)
def told_of(  # type: ignore[no-untyped-def]
    ranges, things, which, num_things, sensor, free, ends, poses, ages, angle_min, increment
):
    """Return which shares of things' ends are free, known and left; shape (M, 3).

    Args:
        ranges: Of the newest scan, shape (N,), m.
        things: First and last beam of each thing, as `ends` of `cluster_beams`.
        which: Which of them to look at, shape (M,).
        num_things: How many those are.
        sensor: x, y, yaw of the sensor now.
        free: As in `SeenFree`, as the next ones.
        ends: See there.
        poses: See there.
        ages: See there.
        angle_min: Bearing of the first beam, rad.
        increment: From beam to beam, rad.
    """
    told = np.zeros((num_things, 3))
    if free.shape[1] != len(ranges):
        return told
    num = len(ranges)
    for n in range(num_things):
        first = things[which[n], 0]
        spread = (things[which[n], 1] - first) % num
        num_points = min(spread + 1, _POINTS)
        count = 0
        for k in range(num_points):
            m = num_points - 1 - k  # from the other end: a mirrored scan has mirrored points
            along = k * spread // (m + k) if k < m else spread - m * spread // max(m + k, 1)
            i = (first + along) % num
            if ranges[i] > 0.0 and np.isfinite(ranges[i]):
                count += 1
                kind = _kind(ranges, i, sensor, free, ends, poses, ages, angle_min, increment)
                if kind >= 0:
                    told[n, kind] += 1.0
        for kind in range(3):
            told[n, kind] /= max(count, 1)
    return told


@numba.njit(cache=True, nogil=True)
def _kind(  # type: ignore[no-untyped-def]
    ranges, i, sensor, free, ends, poses, ages, angle_min, increment
):
    """Return what one end is: `FREE`, `KNOWN`, `LEFT` or -1, in this order if it is several."""
    r = ranges[i]
    bearing = sensor[2] + angle_min + increment * i
    x, y = sensor[0] + r * np.cos(bearing), sensor[1] + r * np.sin(bearing)
    margin = _MARGIN + _MARGIN_SHARE * r
    kind = -1
    for k in range(len(ages)):
        if ages[k] < _NEWEST_S or ages[k] > 2.0:
            continue
        dx, dy = x - poses[k, 0], y - poses[k, 1]
        beam = _beam_at(_bearing(dy, dx) - poses[k, 2] - angle_min, increment)
        if beam >= len(ranges):
            continue
        there = np.sqrt(dx * dx + dy * dy)
        if free[k, beam] > there + margin:
            return FREE
        if free[k, beam] > there - margin:
            kind = KNOWN
        elif kind < 0 and ends[k, beam] > there - _LEFT_BEHIND:
            share = ends[k, beam] / there
            x2, y2 = poses[k, 0] + share * dx - sensor[0], poses[k, 1] + share * dy - sensor[1]
            if _is_seen_beyond(ranges, x2, y2, sensor[2] + angle_min, increment, margin):
                kind = LEFT
    return kind


@numba.njit(cache=True, nogil=True)
def _is_seen_beyond(ranges, x, y, angle_min, increment, margin):  # type: ignore[no-untyped-def]
    """Tell whether the newest scan sees beyond a place, given from the sensor."""
    num = len(ranges)
    beam = _beam_at(_bearing(y, x) - angle_min, increment)
    reach = int(np.ceil(_SLACK_RAD / abs(increment)))
    for n in range(max(beam - reach, 0), min(beam + reach, num - 1) + 1):
        if not ranges[n] > np.sqrt(x * x + y * y) + margin:
            return False
    return beam < num


@numba.njit(cache=True, nogil=True, inline="always")
def _beam_at(off, increment):  # type: ignore[no-untyped-def]
    """Return the beam at an angle from the first one, which may be beyond the last."""
    off = off if increment > 0.0 else -off
    while off < -0.5 * abs(increment):
        off += 2.0 * np.pi
    while off >= 2.0 * np.pi - 0.5 * abs(increment):
        off -= 2.0 * np.pi
    return int(np.rint(off / abs(increment)))
