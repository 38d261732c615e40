"""Tracks of people from scans: where they are and how they move over the ground.

A scan falls into things (`scan_clusters`, `scan_shapes`); each is held against where it was free a
moment ago (`seen_free`); tracks take what fits them (`track_assignment`), and each says where its
person is, how it moves, and how sure it is that it moves at all (`track_filter`). All of that is in
a frame that odometry holds still, so that a robot that drives and turns gives nothing a velocity.

A control cycle may be shorter than the time between scans: a scan that was there before adds
nothing but time. Whoever is hidden is carried on; whoever is not where free space is seen is gone
sooner.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.obstacle_state import Tracks, no_tracks
from sjmc_planner.planning import Obstacles
from sjmc_planner.scan_clusters import cluster_beams
from sjmc_planner.scan_shapes import NUM_COLUMNS, shapes_of
from sjmc_planner.seen_free import SeenFree, told_of
from sjmc_planner.track_assignment import NUM_CANDIDATE_COLUMNS, candidates_of
from sjmc_planner.track_report import report
from sjmc_planner.track_update import (
    AGE,
    NUM_INFO,
    NUMBER,
    SIZE,
    UNSEEN,
    age_tracks,
    begin_new,
    drop_gone,
    see,
)
from sjmc_planner.tracking_config import TrackingConfig

_MOST = 128  # tracks
_MOST_CANDIDATES = 1024
_JUMP_M = 2.0  # a robot that is elsewhere at once has lost everybody
_JUMP_S = 2.0  # and so has one that did not look


class PeopleTracker:
    """The obstacles of a person's size, followed from scan to scan.

    Args:
        config: Settings.
    """

    def __init__(self, config: TrackingConfig) -> None:
        self._config = config
        self._candidates = np.zeros((_MOST_CANDIDATES, NUM_CANDIDATE_COLUMNS))
        self._states, self._state_covs = np.zeros((_MOST, 4)), np.zeros((_MOST, 4, 4))
        self._last_number = 0
        self.reset()

    def reset(self) -> None:
        """Forget everybody."""
        self._base = np.zeros(3)
        tracks = np.zeros((_MOST, 2, 4)), np.zeros((_MOST, 2, 4, 4))
        self._tracks = (*tracks, np.zeros(_MOST), np.zeros((_MOST, NUM_INFO)))
        self._num = 0
        self._seen_free = SeenFree()
        self._last: Scan | None = None
        self._since = 0.0

    def update(self, obstacles: Obstacles, moved: SE2, dt: float) -> Tracks:
        """Return who is where now.

        Args:
            obstacles: The newest scan; one that was given before adds nothing but time.
            moved: Where the robot is, seen from where it was at the last call.
            dt: Time since the last call, s.
        """
        if abs(moved.x) + abs(moved.y) > _JUMP_M or not 0.0 <= dt <= _JUMP_S:
            self.reset()
            moved, dt = SE2(0.0, 0.0, 0.0), 0.0
        self._base = _moved(self._base, moved)
        age_tracks(*self._tracks, self._num, self._config.accel_m_s2, dt)
        self._seen_free.age(dt)
        self._since += dt
        if obstacles.scan is not self._last:
            self._see(obstacles)
        return self._result()

    def _see(self, obstacles: Obstacles) -> None:
        scan, config = obstacles.scan, self._config
        ranges = np.ascontiguousarray(scan.ranges, dtype=np.float64)
        sensor = _moved(self._base, obstacles.T_base_sensor)
        beams = scan.angle_min, scan.angle_increment
        self._labels = np.empty(len(ranges), dtype=np.int64)
        ends = np.empty((len(ranges), 3), dtype=np.int64)
        num_things = cluster_beams(
            ranges, scan.range_min, min(scan.range_max, config.range_m),
            abs(scan.angle_increment), config.body_width_m, self._labels, ends,
        )  # fmt: skip
        shapes = np.empty((num_things, NUM_COLUMNS))
        self._things = np.empty(num_things, dtype=np.int64)
        num_shapes = shapes_of(
            ranges, ends, num_things, *beams, sensor, config.body_width_m,
            0.8 * config.person_radius_m, shapes, self._things,
        )  # fmt: skip
        told = told_of(ranges, ends, self._things, num_shapes, sensor, *self._seen_free.kept())
        self._seen_free.keep(scan, ranges, sensor)
        num_candidates = candidates_of(
            shapes, num_shapes, told, config.leg_width_m, config.step_m, self._candidates
        )
        candidates, least = (self._candidates, num_candidates), config.person_radius_m
        taken = see(*self._tracks, self._num, *candidates, num_shapes, self._since, least)
        self._num = drop_gone(
            *self._tracks, self._num, ranges, *beams, sensor, config.confirm_s, config.memory_s
        )
        self._num, self._last_number = begin_new(
            *self._tracks, self._num, *candidates, taken, least, self._last_number
        )
        self._last, self._since = scan, 0.0

    def _result(self) -> Tracks:
        beam_track = np.empty(len(self._labels), dtype=np.int64)
        shown = report(
            *self._tracks, self._num, self._base, self._config.confirm_s, self._things,
            self._labels, self._states, self._state_covs, beam_track,
        )  # fmt: skip
        if not len(shown):
            return no_tracks(len(beam_track))
        num, info = len(shown), self._tracks[3][shown]
        state = self._states[:num].copy()
        return Tracks(
            number=info[:, NUMBER].astype(np.int64), position=state[:, :2], velocity=state[:, 2:],
            cov=self._state_covs[:num].copy(), radius=info[:, SIZE], age_s=info[:, AGE],
            unseen_s=info[:, UNSEEN], is_moving=self._tracks[2][shown], beam_track=beam_track,
        )  # fmt: skip


def _moved(pose: np.ndarray, by: SE2) -> np.ndarray:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array(
        [pose[0] + c * by.x - s * by.y, pose[1] + s * by.x + c * by.y, pose[2] + by.yaw]
    )
