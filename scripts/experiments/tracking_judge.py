"""How well people are followed, by the truth.

Who counts as seen: nearer than 6 m and than the laser reaches, with at least four beams that end
within 0.45 m of their middle. A person is followed by the nearest track within 0.6 m.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.tracking_drives import Look
from floornav_common.se2 import SE2
from sjmc_planner.obstacle_state import Tracks

_SEEN_M, _BEAMS, _ABOUT_M = 6.0, 4, 0.45
_FOLLOWED_M, _SAME_S = 0.6, 1.0
_WALKS, _SETTLED_S = 0.3, 1.0
_KNOWN_M_S = 0.4  # a velocity is known once its error is below this
_MOVES_M_S, _AWAY_M = 0.25, 1.0  # a false mover is as fast, and nobody is as near
_AFTER_SLIP_S = 2.0


@dataclass
class TrackingJudge:
    """Takes looks and tracks, and says how good they were.

    Attributes:
        velocity_errors: Of walkers followed for a second, m/s.
        place_errors: Of the same, m.
        nees: Squared errors of their states over their covariance; 4 on average if that is right.
        delays: From being seen first until the velocity was known, s.
    """

    velocity_errors: list[float] = field(default_factory=list)
    place_errors: list[float] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    delays: list[float] = field(default_factory=list)
    _num_seen: int = 0
    _num_followed: int = 0
    _num_switches: int = 0
    _last: dict[str, tuple[int, float]] = field(default_factory=dict)
    _first: dict[str, float] = field(default_factory=dict)
    _false: set[int] = field(default_factory=set)
    _seconds: float = 0.0
    _period: float = 0.0
    _before: float | None = None
    _slipped_at: float = -np.inf

    def note(self, look: Look, tracks: Tracks) -> None:
        """Take one look and what the tracker made of it; not while odometry is wrong."""
        self._period = 0.0 if self._before is None else look.time_s - self._before
        self._before = look.time_s
        if look.is_slipping:
            self._slipped_at = look.time_s
        if look.time_s - self._slipped_at < _AFTER_SLIP_S:
            return
        self._seconds += self._period
        T_base_world = look.truth.inverse()
        places = T_base_world @ look.people[:, :2]
        velocities = SE2(0.0, 0.0, T_base_world.yaw) @ look.people[:, 2:]
        for k in np.flatnonzero(_is_seen(look, places)):
            self._note_person(look.names[k], look.time_s, places[k], velocities[k], tracks)
        self._note_false(tracks, places)

    def figures(self) -> dict[str, Any]:
        """Return all figures; None where there was nothing to judge."""
        minutes, person_minutes = self._seconds / 60.0, self._num_seen * self._period / 60.0
        return {
            "seen_at_once": _share(self._num_seen * self._period, self._seconds),
            "followed": _share(self._num_followed, self._num_seen),
            "velocity_error_m_s": _percentile(self.velocity_errors, 50.0),
            "velocity_error_p90_m_s": _percentile(self.velocity_errors, 90.0),
            "place_error_m": _percentile(self.place_errors, 50.0),
            "nees_mean": float(np.mean(self.nees)) if self.nees else None,
            "nees_median": _percentile(self.nees, 50.0),
            "first_velocity_s": _percentile(self.delays, 50.0),
            "switches_per_person_minute": _share(self._num_switches, person_minutes),
            "false_movers_per_minute": _share(len(self._false), minutes),
        }

    def _note_person(
        self, name: str, time_s: float, place: np.ndarray, velocity: np.ndarray, tracks: Tracks
    ) -> None:
        self._num_seen += 1
        self._first.setdefault(name, time_s)
        off = np.hypot(*(tracks.position - place).T)
        if off.min(initial=np.inf) > _FOLLOWED_M:
            return
        n = int(np.argmin(off))
        number = int(tracks.number[n])
        self._num_followed += 1
        last, at = self._last.get(name, (number, time_s))
        self._num_switches += last != number and time_s - at < _SAME_S
        self._last[name] = number, time_s
        error = tracks.velocity[n] - velocity
        size = float(np.hypot(*error))
        if size < _KNOWN_M_S and self._first[name] >= 0.0:
            self.delays.append(time_s - self._first[name])
            self._first[name] = -1.0
        if np.hypot(*velocity) > _WALKS and tracks.age_s[n] > _SETTLED_S:
            self.velocity_errors.append(size)
            self.place_errors.append(float(off[n]))
            state = np.concatenate((tracks.position[n] - place, error))
            self.nees.append(float(state @ np.linalg.solve(tracks.cov[n], state)))

    def _note_false(self, tracks: Tracks, places: np.ndarray) -> None:
        is_moving = (np.hypot(*tracks.velocity.T) > _MOVES_M_S) & (tracks.unseen_s == 0.0)
        for n in np.flatnonzero(is_moving):
            off = np.hypot(*(places - tracks.position[n]).T)
            if off.min(initial=np.inf) > _AWAY_M:
                self._false.add(int(tracks.number[n]))


def _is_seen(look: Look, places: np.ndarray) -> np.ndarray:
    ends = look.T_base_sensor @ look.scan.points()
    off = np.hypot(*(places[:, None] - ends[None]).transpose(2, 0, 1))
    sensor = np.array([look.T_base_sensor.x, look.T_base_sensor.y])
    reach = min(_SEEN_M, look.scan.range_max - 0.3)
    is_near = np.hypot(*(places - sensor).T) < reach
    return is_near & ((off < _ABOUT_M).sum(axis=1) >= _BEAMS)


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > 0.0 else None


def _percentile(values: list[float], percent: float) -> float | None:
    return float(np.percentile(values, percent)) if values else None
