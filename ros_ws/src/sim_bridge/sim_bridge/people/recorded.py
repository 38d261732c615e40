"""Recorded people: `obsmat` files as of ETH and UCY, interpolated between their samples."""

from __future__ import annotations

import gzip
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.people.schema import Recording
from sim_bridge.schema import WorldError

_COLUMNS = 8  # frame id x z y vx vz vy
_LONGEST_GAP_S = 2.0


@dataclass(frozen=True)
class Track:
    """One visit of one recorded person.

    Attributes:
        number: Id in the file.
        slot: Which body it has; two people at the same time have two.
        times: Since simulated time 0, shape (N,), s, increasing.
        points: In the world, shape (N, 2), m.
        walked: Distance walked so far, shape (N,), m.
    """

    number: int
    slot: int
    times: np.ndarray
    points: np.ndarray
    walked: np.ndarray

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray, float] | None:
        """Return position (2,), velocity (2,) and distance walked; None when not there."""
        if not self.times[0] <= time <= self.times[-1]:
            return None
        k = min(int(np.searchsorted(self.times, time, side="right")), len(self.times) - 1)
        dt = self.times[k] - self.times[k - 1]
        share = (time - self.times[k - 1]) / dt
        step = self.points[k] - self.points[k - 1]
        walked = self.walked[k - 1] + share * (self.walked[k] - self.walked[k - 1])
        return self.points[k - 1] + share * step, step / dt, float(walked)


def read_obsmat(path: Path) -> np.ndarray:
    """Return the rows of an `obsmat` file: frame, id, x, y; shape (N, 4), as in the file.

    Raises:
        WorldError: If it cannot be read or is not of that format; one line.
    """
    try:
        data = path.read_bytes()
        text = (gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data).decode()
    except OSError as error:
        raise WorldError(
            f"recorded people: {path}: {error.strerror or error}; name another file with "
            "world_parameters:=[file=...] (demo.py: --set file=...) if the world has that figure"
        ) from error
    except (UnicodeDecodeError, EOFError, zlib.error) as error:
        raise WorldError(f"recorded people: {path}: not text: {error}") from error
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if words and (len(values) != _COLUMNS or not np.isfinite(values).all()):
            expected = "expected 8 finite numbers: frame id x z y vx vz vy"
            raise WorldError(f"recorded people: {path}, line {number}: {expected}")
        if words:
            rows.append(values)
    if not rows:
        raise WorldError(f"recorded people: {path}: holds no rows")
    return np.array(rows)[:, [0, 1, 2, 4]]


def tracks_of(recording: Recording) -> list[Track]:
    """Return everyone in the region after the start, in the order they come.

    Someone who is away from the region, or unseen for over 2 s, comes back as another track.

    Raises:
        WorldError: If the file cannot be used.
    """
    rows = read_obsmat(Path(recording.file).expanduser())
    low, high = np.array(recording.low_m), np.array(recording.high_m)
    is_inside = np.all((rows[:, 2:] >= low) & (rows[:, 2:] <= high), axis=1)
    T = SE2(*recording.position_m, np.radians(recording.yaw_deg))
    visits = []
    for number in np.unique(rows[:, 1]):
        index = np.flatnonzero(rows[:, 1] == number)
        index = index[np.argsort(rows[index, 0], kind="stable")]
        own = rows[index]
        times = own[:, 0] / recording.frames_per_s - recording.starts_s
        for part in _runs(times, is_inside[index]):
            if len(part) > 1 and times[part[-1]] > 0.0:
                visits.append((times[part], T @ own[part, 2:], int(number)))
    return _in_slots(visits)


def _runs(times: np.ndarray, is_inside: np.ndarray) -> list[np.ndarray]:
    """Return indices of unbroken runs: inside, time going on, no long gap."""
    index = np.flatnonzero(is_inside)
    gap = np.diff(times[index])
    is_cut = (np.diff(index) > 1) | (gap > _LONGEST_GAP_S)
    runs = np.split(index, np.flatnonzero(is_cut) + 1)
    return [run[np.concatenate(([True], np.diff(times[run]) > 0.0))] for run in runs if len(run)]


def _in_slots(visits: list[tuple[np.ndarray, np.ndarray, int]]) -> list[Track]:
    tracks: list[Track] = []
    free_from: list[float] = []
    for times, points, number in sorted(visits, key=lambda visit: (visit[0][0], visit[2])):
        slot = next((k for k, end in enumerate(free_from) if end < times[0]), len(free_from))
        free_from[slot : slot + 1] = [float(times[-1])]
        steps = np.hypot(*np.diff(points, axis=0).T)
        walked = np.concatenate(([0.0], np.cumsum(steps)))
        tracks.append(Track(number, slot, times, points, walked))
    return tracks
