"""Tracks of people from scans: where they are and how they move over the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.obstacle_state import Tracks, no_tracks
from sjmc_planner.planning import Obstacles
from sjmc_planner.scan_clusters import cluster_beams
from sjmc_planner.tracking_config import TrackingConfig

_NOISE = 0.07
_GATE2 = 9.2  # chi^2 of two dimensions, 99 %


@dataclass
class _Track:
    number: int
    mean: np.ndarray
    cov: np.ndarray
    radius: float
    age: float = 0.0
    unseen: float = 0.0
    beams: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


class PeopleTracker:
    """The obstacles of a person's size, followed from scan to scan.

    Args:
        config: Settings.
    """

    def __init__(self, config: TrackingConfig) -> None:
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget everybody."""
        self._T_odom_base = SE2.identity()
        self._tracks: list[_Track] = []
        self._last: Scan | None = None
        self._num = 0

    def update(self, obstacles: Obstacles, moved: SE2, dt: float) -> Tracks:
        """Return who is where now.

        Args:
            obstacles: The newest scan; one that was given before adds nothing but time.
            moved: Where the robot is, seen from where it was at the last call.
            dt: Time since the last call, s.
        """
        self._T_odom_base = self._T_odom_base @ moved
        for track in self._tracks:
            _predict(track, self._config.accel_m_s2, dt)
        if obstacles.scan is not self._last:
            self._last = obstacles.scan
            self._see(obstacles)
        self._tracks = [t for t in self._tracks if t.unseen <= self._config.memory_s]
        return self._result(len(obstacles.scan.ranges))

    def _see(self, obstacles: Obstacles) -> None:
        for middle, half, beams in self._candidates(obstacles):
            near = [(_distance2(t, middle), n) for n, t in enumerate(self._tracks) if t.unseen > 0]
            best = min(near, default=(math.inf, -1))
            if best[0] < _GATE2:
                track = self._tracks[best[1]]
                _correct(track, middle)
                track.unseen, track.beams = 0.0, beams
                track.radius = max(self._config.person_radius_m, half)
            else:
                self._num += 1
                cov = np.diag([_NOISE**2, _NOISE**2, 1.0, 1.0])
                mean = np.array([*middle, 0.0, 0.0])
                radius = max(self._config.person_radius_m, half)
                self._tracks.append(_Track(self._num, mean, cov, radius, beams=beams))

    def _candidates(self, obstacles: Obstacles) -> list[tuple[np.ndarray, float, np.ndarray]]:
        scan, config = obstacles.scan, self._config
        labels = np.empty(len(scan.ranges), dtype=np.int64)
        farthest = min(scan.range_max, config.range_m)
        step = abs(scan.angle_increment)
        num = cluster_beams(scan.ranges, scan.range_min, farthest, step, labels)
        T = self._T_odom_base @ obstacles.T_base_sensor
        unit = np.column_stack((np.cos(scan.angles), np.sin(scan.angles)))
        with np.errstate(invalid="ignore"):
            points = T @ (scan.ranges[:, None] * unit)
        legs: list[tuple[np.ndarray, float, np.ndarray]] = []
        bodies: list[tuple[np.ndarray, float, np.ndarray]] = []
        for label in range(num):
            beams = np.flatnonzero(labels == label)
            ends = points[beams]
            width = float(np.hypot(*(ends[-1] - ends[0])))
            if len(beams) < 3 or width > config.body_width_m:
                continue
            away = ends.mean(axis=0) - (T.x, T.y)
            middle = ends.mean(axis=0) + 0.4 * width * away / np.hypot(*away)
            (legs if width < config.leg_width_m else bodies).append((middle, width / 2.0, beams))
        return bodies + _paired(legs, config.step_m)

    def _result(self, num_beams: int) -> Tracks:
        shown = [t for t in self._tracks if t.age >= self._config.confirm_s]
        if not shown:
            return no_tracks(num_beams)
        T = self._T_odom_base.inverse()
        mean = np.array([t.mean for t in shown])
        turn = SE2(0.0, 0.0, T.yaw)
        c, s = math.cos(T.yaw), math.sin(T.yaw)
        R = np.kron(np.eye(2), np.array([[c, -s], [s, c]]))
        beam_track = np.full(num_beams, -1)
        for n, track in enumerate(shown):
            if track.unseen == 0.0:
                beam_track[track.beams] = n
        return Tracks(
            np.array([t.number for t in shown]), T @ mean[:, :2], turn @ mean[:, 2:],
            R @ np.array([t.cov for t in shown]) @ R.T, np.array([t.radius for t in shown]),
            np.array([t.age for t in shown]), np.array([t.unseen for t in shown]),
            (np.hypot(mean[:, 2], mean[:, 3]) > 0.2).astype(float), beam_track,
        )  # fmt: skip


def _paired(
    legs: list[tuple[np.ndarray, float, np.ndarray]], step: float
) -> list[tuple[np.ndarray, float, np.ndarray]]:
    """Return legs put together two by two, nearest first; one that is left stays alone."""
    pairs = sorted(
        (float(np.hypot(*(a[0] - b[0]))), i, j)
        for i, a in enumerate(legs) for j, b in enumerate(legs[:i])
    )  # fmt: skip
    used: set[int] = set()
    found = []
    for distance, i, j in pairs:
        if distance <= step and i not in used and j not in used:
            used |= {i, j}
            a, b = legs[i], legs[j]
            beams = np.concatenate((a[2], b[2]))
            found.append((0.5 * (a[0] + b[0]), 0.5 * distance + max(a[1], b[1]), beams))
    return found + [leg for k, leg in enumerate(legs) if k not in used]


def _predict(track: _Track, accel: float, dt: float) -> None:
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    G = np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]]) * accel**2
    track.mean = F @ track.mean
    track.cov = F @ track.cov @ F.T + np.kron(G, np.eye(2))
    track.age += dt
    track.unseen += dt


def _distance2(track: _Track, middle: np.ndarray) -> float:
    S = track.cov[:2, :2] + _NOISE**2 * np.eye(2)
    off = middle - track.mean[:2]
    return float(off @ np.linalg.solve(S, off))


def _correct(track: _Track, middle: np.ndarray) -> None:
    S = track.cov[:2, :2] + _NOISE**2 * np.eye(2)
    K = track.cov[:, :2] @ np.linalg.inv(S)
    track.mean = track.mean + K @ (middle - track.mean[:2])
    track.cov = track.cov - K @ track.cov[:2]
