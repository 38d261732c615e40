"""What `sjmc` knows of its surroundings: things that stand, people held apart, and the blind rear.

A track that moves, or is no wider than a person, is a person: a disk with a velocity. All other
beams end at things. Things are thinned to the nearest in each of some directions of the sensor, and
those that go out of its view are kept for a while, moved along with the robot. So is what comes
nearer than the sensor measures: such a beam says only that something is near, and taken to end at
`range_min` it would recede before a robot that goes on towards it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numba
import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamEnds, BeamReader
from sjmc_planner.known_obstacles import hides
from sjmc_planner.obstacle_state import Tracks
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import Obstacles, RobotState
from sjmc_planner.tracking_config import TrackingConfig

_BINS = 181  # directions of the sensor, as many to the left as to the right
_KEEP_M = 1.2  # around the base: farther off what went out of view is forgotten
_KEEP_S = 3.0
_KEEP_TRAVEL = 0.5  # so far odometry is trusted with what is too near to measure, m
_MOVES = 0.5  # probability
_STANDS = 0.15  # m/s
_NARROWS = 0.05  # m/s: how fast what was wide counts as narrower once it looks it
_PANE = 0.25  # who is seen this near to a pane, or through it, is no person in the way, m
_NEAR_M = 2.5
_EDGE = 0.15  # beams that end this near to a person's disk are the person's, m


@dataclass(frozen=True)
class Scene:
    """Surroundings in the base frame.

    Attributes:
        ends: Where the beams end.
        things: What stands, what is known beside the scan too, shape (M, 2), m.
        solids: The same and what is seen of people who stand, shape (K, 2), m.
        people: Rows x, y, vx, vy, radius, shape (N, 5).
        number: Of each person, shape (N,), int.
        is_moving: Whether each is on its way, shape (N,), bool.
    """

    ends: BeamEnds
    things: np.ndarray
    solids: np.ndarray
    people: np.ndarray
    number: np.ndarray
    is_moving: np.ndarray

    @property
    def num_walking(self) -> int:
        """How many people walk near the robot."""
        x, y = self.people[:, 0], self.people[:, 1]
        return int(np.count_nonzero((x * x + y * y < _NEAR_M * _NEAR_M) & self.is_moving))


class SceneReader:
    """Turns scans into scenes.

    Args:
        tracking: Settings of the tracker.
        person_width: What stands and is wider is a thing, m.
        unseen_gap: See `BeamReader`, rad.
        period: Time between two calls, s.
    """

    def __init__(
        self, tracking: TrackingConfig, person_width: float, unseen_gap: float, period: float
    ) -> None:
        self._tracker, self._reader = PeopleTracker(tracking), BeamReader(unseen_gap)
        self._person_width, self._period = person_width, period
        self._scan: Scan | None = None
        self._beams = np.zeros(0, dtype=np.int64)
        self._widths = np.zeros(0), np.zeros(0, dtype=np.int64)
        self._kept = np.zeros((0, 3))
        self._last = np.zeros((0, 2))

    def read(self, state: RobotState, obstacles: Obstacles) -> Scene:
        """Return the scene of now."""
        tracks = self._tracker.update(obstacles, state.moved, self._period)
        tracks = self._with_beams(tracks, obstacles.scan)
        ends = self._reader.read(obstacles)
        known = obstacles.known
        is_person = self._people(tracks, ends)
        is_person &= ~hides(np.array(ends.pose[:2]), tracks.position, known, _PANE)
        speed = np.hypot(tracks.velocity[:, 0], tracks.velocity[:, 1])
        moves = (tracks.is_moving > _MOVES) & (speed > _STANDS)
        rows = np.column_stack((tracks.position, tracks.velocity, tracks.radius))
        rows[~moves, 2:4] = 0.0
        disks = np.column_stack((tracks.position, tracks.radius + _EDGE))
        args = ends.ranges, self._reader.units, tracks.beam_track, is_person, moves, disks
        things, solids = _things(*args, ends.pose, _BINS)
        near = float(obstacles.scan.range_min)
        rear = self._remember(state.moved, solids, ends, near, disks, moves)
        return Scene(
            ends, np.concatenate((things, rear, known)), np.concatenate((solids, rear, known)),
            rows[is_person], tracks.number[is_person], moves[is_person],
        )  # fmt: skip

    def _with_beams(self, tracks: Tracks, scan: Scan) -> Tracks:
        """Return tracks that know their beams also where the scan is the one of before."""
        if scan is not self._scan:
            known = np.append(tracks.number, -1)
            self._scan, self._beams = scan, known[tracks.beam_track]
            return tracks
        order = np.append(np.argsort(tracks.number), -1)
        sorted_numbers = np.append(tracks.number[order[:-1]], np.iinfo(np.int64).max)
        at = np.searchsorted(sorted_numbers, self._beams)
        rows = np.where(sorted_numbers[at] == self._beams, order[at], -1)
        return replace(tracks, beam_track=rows)

    def _people(self, tracks: Tracks, ends: BeamEnds) -> np.ndarray:
        """Tell who is a person: what moves, or was never seen to be wider for some time."""
        widths = _widths(
            ends.ranges, tracks.beam_track, ends.angle_min, ends.angle_increment, len(tracks)
        )
        widths = _not_sooner(widths, tracks.number, *self._widths, _NARROWS * self._period)
        self._widths = widths, tracks.number
        return np.asarray((tracks.is_moving > _MOVES) | (widths <= self._person_width))

    def _remember(
        self, moved: SE2, solids: np.ndarray, ends: BeamEnds, near: float, disks: np.ndarray,
        moves: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Return what has gone out of view, or came nearer than `near`, shape (K, 2), m."""
        beams = ends.ranges, ends.angle_min, ends.angle_increment, ends.pose
        motion = moved.x, moved.y, moved.yaw, self._period
        self._kept = _gone(self._last, self._kept, *motion, *beams, near, disks, moves)
        self._last = solids
        return self._kept[:, :2]


@numba.njit(cache=True, nogil=True)
def _widths(ranges, beam_track, angle_min, step, num):  # type: ignore[no-untyped-def]
    """Return how wide each track is in the scan, between its outer beams, shape (num,), m."""
    first, last = np.full(num, -1), np.full(num, -1)
    for i in range(len(beam_track)):
        k = beam_track[i]
        if k >= 0 and np.isfinite(ranges[i]):
            if first[k] < 0:
                first[k] = i
            last[k] = i
    widths = np.zeros(num)
    for k in range(num):
        if first[k] >= 0:
            a, b, turn = ranges[first[k]], ranges[last[k]], step * (last[k] - first[k])
            widths[k] = math.sqrt(max(a * a + b * b - 2.0 * a * b * math.cos(turn), 0.0))
    return widths


@numba.njit(cache=True, nogil=True)
def _not_sooner(widths, numbers, before, numbers_before, shrunk):  # type: ignore[no-untyped-def]
    """Return widths that have shrunk no faster than allowed since the last call."""
    found = widths.copy()
    for k in range(len(widths)):
        for j in range(len(before)):
            if numbers_before[j] == numbers[k]:
                found[k] = max(found[k], before[j] - shrunk)
    return found


@numba.njit(cache=True, nogil=True)
def _things(ranges, units, beam_track, is_person, moves, disks, pose, num_bins):  # type: ignore[no-untyped-def]
    """Return the nearest in each direction of what is no person, and of what does not walk.

    Both in the base frame, shapes (K, 2) and (L, 2); what is on a person's disk is the person's.
    """
    middle, per_bin = 0.5 * (len(ranges) - 1), max(len(ranges) / (num_bins - 2), 1.0)
    nearest = np.full((2, num_bins), np.inf)
    off = np.full((2, num_bins), np.inf)
    ends = np.empty((2, num_bins, 2))
    for i in range(len(ranges)):
        r = ranges[i]
        if not r < np.inf:
            continue
        b, beside = int(np.rint((i - middle) / per_bin)) + num_bins // 2, abs(i - middle)
        k = beam_track[i]
        for kind in range(2):
            is_own = k >= 0 and (moves[k] if kind == 1 else is_person[k])
            is_next = r < nearest[kind, b] or (r == nearest[kind, b] and beside < off[kind, b])
            if is_own or not is_next:
                continue
            px, py = r * units[i, 0], r * units[i, 1]
            x = pose[0] + (pose[2] * px - pose[3] * py)
            y = pose[1] + (pose[3] * px + pose[2] * py)
            if not _is_on_disk(x, y, disks, moves if kind == 1 else is_person):
                nearest[kind, b], off[kind, b] = r, beside
                ends[kind, b, 0], ends[kind, b, 1] = x, y
    return ends[0][nearest[0] < np.inf], ends[1][nearest[1] < np.inf]


@numba.njit(cache=True, nogil=True, inline="always")
def _is_on_disk(x, y, disks, counts):  # type: ignore[no-untyped-def]
    for i in range(len(disks)):
        dx, dy = x - disks[i, 0], y - disks[i, 1]
        if counts[i] and dx * dx + dy * dy < disks[i, 2] * disks[i, 2]:
            return True
    return False


@numba.njit(cache=True, nogil=True)
def _gone(last, kept, x, y, yaw, period, ranges, angle_min, step, pose, near, disks, moves):  # type: ignore[no-untyped-def]
    """Return what of the last things and those kept is near and out of view: rows x, y, age.

    Of what is too near to measure, the nearest in each beam; it ages with the way, not with time.
    """
    found = np.empty((len(last) + len(kept), 3))
    row_of = np.full(len(ranges), -1)
    travel_age = math.hypot(x, y) * _KEEP_S / _KEEP_TRAVEL
    c, s = math.cos(yaw), math.sin(yaw)
    count = 0
    for i in range(len(found)):
        is_new = i < len(last)
        j = i - len(last)
        px, py = (last[i, 0], last[i, 1]) if is_new else (kept[j, 0], kept[j, 1])
        dx, dy = px - x, py - y
        qx, qy = c * dx + s * dy, c * dy - s * dx
        sx, sy = qx - pose[0], qy - pose[1]
        beam = (math.atan2(sy, sx) - pose[4] - angle_min) * (1.0 if step > 0.0 else -1.0)
        k = int(np.rint(beam % (2.0 * math.pi) / abs(step)))
        if k == len(ranges) and abs(step) * (k + 0.5) > 2.0 * math.pi:
            k = 0  # the beams go once around
        is_out = k >= len(ranges) or np.isnan(ranges[k])
        is_near = not is_out and ranges[k] <= near and sx * sx + sy * sy < near * near
        age = 0.0 if is_new else kept[j, 2] + (travel_age if is_near else period)
        if qx * qx + qy * qy > _KEEP_M * _KEEP_M or age > _KEEP_S:
            continue
        if not (is_out or is_near) or _is_on_disk(qx, qy, disks, moves):
            continue
        row = count
        if is_near and row_of[k] >= 0:
            row = row_of[k]
            before = (found[row, 0] - pose[0]) ** 2 + (found[row, 1] - pose[1]) ** 2
            if before <= sx * sx + sy * sy:
                continue
        elif is_near:
            row_of[k] = row
        found[row, 0], found[row, 1], found[row, 2] = qx, qy, age
        count = max(count, row + 1)
    return found[:count].copy()
