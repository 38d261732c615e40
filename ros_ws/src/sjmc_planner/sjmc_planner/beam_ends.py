"""Where the beams of a scan end, in the robot's frame: the points that a method steers around.

What a beam says is what `growth` takes it to say: `+inf` is free to `range_max`; `-inf`, and what
is below `range_min`, stands at `range_min`; NaN, and a driver's 0, was not seen. A narrow gap of
those takes the nearer range beside it; a wide one is not free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sjmc_planner.free_times import _bearing
from sjmc_planner.planning import Obstacles

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
_TURN = 2.0 * math.pi
_ON = 0.01  # of a step: this near to a beam is on it
_LOOKS = np.array([0.1, 0.5, 1.0])  # of a reach: where a direction is looked along


@dataclass(frozen=True)
class BeamEnds:
    """What a scan shows.

    Attributes:
        points: What stands there, in the base frame, shape (M, 2), m.
        ranges: How far each beam saw, from the sensor, shape (N,), m; inf for nothing within its
            horizon, NaN if it was not looked.
        angle_min: Bearing of the first beam, from the sensor, rad.
        angle_increment: Step from beam to beam, rad.
        pose: The sensor in the base frame: x, y, cos(yaw), sin(yaw), yaw.
        horizon: How far was looked, m.
    """

    points: np.ndarray
    ranges: np.ndarray
    angle_min: float
    angle_increment: float
    pose: tuple[float, float, float, float, float]
    horizon: float

    def unseen(self, bearings: np.ndarray, radius: float, reach: float) -> np.ndarray:
        """Return which directions of the base no beam looked along, shape (K,), bool.

        Args:
            bearings: The directions, shape (K,), rad.
            radius: Nearer than this the robot itself is, m.
            reach: How far to look, m.
        """
        beams = self.ranges, self.angle_min, self.angle_increment
        return np.asarray(_unseen(bearings, radius, reach, *beams, self.pose, _LOOKS))


class BeamReader:
    """Reads scans; keeps the directions of the beams from one to the next.

    Args:
        unseen_gap: Gaps of unseen beams up to this take the nearer range beside them, rad.
    """

    def __init__(self, unseen_gap: float) -> None:
        self._gap = unseen_gap
        self._kind: tuple[float, float, int] = (0.0, 0.0, -1)
        self._units = np.zeros((0, 2))

    @property
    def units(self) -> np.ndarray:
        """Directions of the beams of the scan read last, from the sensor, shape (N, 2)."""
        return self._units

    def read(self, obstacles: Obstacles) -> BeamEnds:
        """Return where the beams of a scan end."""
        scan, T = obstacles.scan, obstacles.T_base_sensor
        kind = scan.angle_min, scan.angle_increment, len(scan.ranges)
        if kind != self._kind:
            self._kind = kind
            self._units = np.column_stack((np.cos(scan.angles), np.sin(scan.angles)))
        step = abs(scan.angle_increment)
        most = int(self._gap / step + 1e-6) if step > 0.0 else 0
        is_round = step * len(scan.ranges) > _TURN - 1e-6
        pose = T.x, T.y, math.cos(T.yaw), math.sin(T.yaw), T.yaw
        limits = float(scan.range_min), float(scan.range_max)
        raw = np.asarray(scan.ranges, dtype=float)
        ranges, points = _ends(raw, self._units, *limits, most, is_round, pose)
        return BeamEnds(points, ranges, *kind[:2], pose, limits[1])


@numba.njit(cache=True, nogil=True)
def _ends(raw, units, range_min, range_max, most, is_round, pose):  # type: ignore[no-untyped-def]
    num = len(raw)
    ranges = np.empty(num)
    for i in range(num):
        r = raw[i]
        if r > range_max:
            r = np.inf
        elif r == 0.0 and range_min > 0.0:
            r = np.nan  # drivers write 0 for "no return" too
        elif r < range_min:
            r = range_min
        ranges[i] = r
    _fill(ranges, most, is_round)
    points = np.empty((num, 2))
    count = 0
    x, y, c, s, _ = pose
    for i in range(num):
        if ranges[i] < np.inf:
            px, py = ranges[i] * units[i, 0], ranges[i] * units[i, 1]
            points[count, 0], points[count, 1] = x + (c * px - s * py), y + (s * px + c * py)
            count += 1
    return ranges, points[:count]


@numba.njit(cache=True, nogil=True)
def _fill(ranges, most, is_round):  # type: ignore[no-untyped-def]
    """Close gaps of at most `most` beams by the nearer range beside them, in place."""
    num = len(ranges)
    start = 0
    while is_round and start < num and np.isnan(ranges[start]):
        start += 1  # from a beam that was seen, no gap runs over the end of a turn
    i = start
    while i < start + num:
        end = i
        while end < start + num and np.isnan(ranges[end % num]):
            end += 1
        if 0 < end - i <= most:
            near = ranges[(i - 1) % num] if is_round or i > 0 else np.nan
            if is_round or end < num:
                near = np.fmin(near, ranges[end % num])
            for k in range(i, end):
                ranges[k % num] = near
        i = max(end, i + 1)


@numba.njit(cache=True, nogil=True, inline="always")
def _seen_to(x, y, ranges, angle_min, step, pose):  # type: ignore[no-untyped-def]
    """Return how far was looked along a point of the base frame, and how far it is.

    The first is the nearer of the two beams beside the point, so that no side is preferred; NaN
    if one of them, or none, was looked along.
    """
    dx, dy = x - pose[0], y - pose[1]
    sx, sy = pose[2] * dx + pose[3] * dy, pose[2] * dy - pose[3] * dx
    num, turn = len(ranges), _TURN / abs(step)
    off = (_bearing(sy, sx) - angle_min) / step
    off -= turn * np.floor(off / turn)
    right, left = int(np.floor(off + _ON)), int(np.ceil(off - _ON))
    if left >= num:
        if turn - num < 0.5:  # the beams go once around
            right, left = min(right, num - 1), 0
        elif off <= num - 0.5:
            right, left = num - 1, num - 1
        elif off >= turn - 0.5:
            right, left = 0, 0
        else:
            return np.nan, 0.0
    a, b = ranges[right], ranges[left]
    far = np.nan if np.isnan(a) or np.isnan(b) else min(a, b)
    return far, np.sqrt(sx * sx + sy * sy)


@numba.njit(cache=True, nogil=True)
def _unseen(bearings, radius, reach, ranges, angle_min, step, pose, looks):  # type: ignore[no-untyped-def]
    found = np.zeros(len(bearings), dtype=np.bool_)
    for k in range(len(bearings)):
        c, s = np.cos(bearings[k]), np.sin(bearings[k])
        for share in looks:
            r = radius + share * reach
            far, _ = _seen_to(r * c, r * s, ranges, angle_min, step, pose)
            found[k] |= np.isnan(far)
    return found
