"""The five-robot recording (UTIAS MRCLAM) as arrays: read whole, and refused with one line.

Ranges are read past: nothing of the third column leaves this file. Bearings to barcodes that no
list names (misreads) are counted and left out. Odometry rows whose stamps step back a few
milliseconds are put in order.
"""

from __future__ import annotations

import gzip
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floornav_common.reporting import UserError

NUM_ROBOTS = 5
MAX_TRUTH_GAP_S = 0.5
_LAST_HOLD_S = 0.02


@dataclass(frozen=True, eq=False)
class RobotLog:
    """What one robot recorded, and where it truly was.

    Attributes:
        odometry: Rows of time (s), forward velocity, angular velocity, shape (N, 3).
        looks: Rows of time (s), subject (1..5 robots, from 6 on landmarks), bearing (rad), (M, 3).
        truth: Rows of time (s), x, y, yaw, shape (K, 4).
        num_unknown: Bearings to barcodes that no list names.
    """

    odometry: np.ndarray
    looks: np.ndarray
    truth: np.ndarray
    num_unknown: int

    def dead_reckoned(self, times: np.ndarray, delay: float) -> np.ndarray:
        """Return x, y, yaw at times by odometry alone, from the origin, shape (T, 3).

        Args:
            times: s.
            delay: How long after its row a velocity takes effect, s.
        """
        stamps = self.odometry[:, 0]
        dt = np.diff(stamps, append=stamps[-1] + _LAST_HOLD_S)
        turns = self.odometry[:, 2] * dt
        yaw = np.concatenate([[0.0], np.cumsum(turns)])
        way, middle = self.odometry[:, 1] * dt, yaw[:-1] + 0.5 * turns
        x = np.concatenate([[0.0], np.cumsum(way * np.cos(middle))])
        y = np.concatenate([[0.0], np.cumsum(way * np.sin(middle))])
        ends = np.append(stamps, stamps[-1] + _LAST_HOLD_S) + delay
        return np.stack([np.interp(times, ends, value) for value in (x, y, yaw)], axis=1)

    def truth_at(self, times: np.ndarray) -> np.ndarray:
        """Return x, y, yaw at times, NaN where truth is missing for over 0.5 s, shape (T, 3)."""
        stamps = self.truth[:, 0]
        columns = [self.truth[:, 1], self.truth[:, 2], np.unwrap(self.truth[:, 3])]
        poses = np.stack([np.interp(times, stamps, value) for value in columns], axis=1)
        after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
        is_far = stamps[after] - stamps[after - 1] > MAX_TRUTH_GAP_S
        poses[is_far | (times < stamps[0]) | (times > stamps[-1])] = np.nan
        return poses


@dataclass(frozen=True, eq=False)
class TeamRecording:
    """The whole recording.

    Attributes:
        robots: By number.
        landmarks: Positions by subject, (2,) each, m.
        start: Stamp of the first odometry row of all robots, s.
        end: Stamp of the last, s.
    """

    robots: dict[int, RobotLog]
    landmarks: dict[int, np.ndarray]
    start: float
    end: float


def load_recording(folder: Path, robots: tuple[int, ...]) -> TeamRecording:
    """Read the logs of some robots.

    Raises:
        UserError: If the folder or a file is missing, cut short or not what it should be.
    """
    if not folder.is_dir():
        raise UserError(f"no such folder: {folder}")
    codes = _table(folder / "Barcodes.dat", 2)
    subjects = {int(code): int(subject) for subject, code in codes}
    rows = _table(folder / "Landmark_Groundtruth.dat", 5)
    landmarks = {int(row[0]): row[1:3] for row in rows}
    missing = sorted({s for s in subjects.values() if s > NUM_ROBOTS} - {*landmarks})
    if missing:
        raise UserError(f"{folder / 'Landmark_Groundtruth.dat'} lacks landmarks {missing}")
    logs = {robot: _robot(folder, robot, subjects) for robot in robots}
    starts = [log.odometry[0, 0] for log in logs.values()]
    ends = [log.odometry[-1, 0] for log in logs.values()]
    return TeamRecording(logs, landmarks, float(min(starts)), float(max(ends)))


def _robot(folder: Path, robot: int, subjects: dict[int, int]) -> RobotLog:
    odometry = _table(folder / f"Robot{robot}_Odometry.dat.gz", 3)
    odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
    path = folder / f"Robot{robot}_Measurement.dat.gz"
    raw = _table(path, 4)
    seen = np.array([subjects.get(int(code), 0) for code in raw[:, 1]])
    is_known = (seen > 0) & (seen != robot)
    if not is_known.any():
        raise UserError(f"{path}: none of its barcodes is in Barcodes.dat")
    looks = np.stack([raw[:, 0], seen, raw[:, 3]], axis=1)[is_known]
    looks = looks[np.argsort(looks[:, 0], kind="stable")]
    truth = _table(folder / f"Robot{robot}_Groundtruth.dat.gz", 4)
    return RobotLog(odometry, looks, truth, int((~is_known).sum()))


def _table(path: Path, num_columns: int) -> np.ndarray:
    """Return the numbers of a file, shape (N, num_columns)."""
    if not path.is_file():
        raise UserError(f"no such file: {path}")
    try:
        raw = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        text = raw.decode("ascii")
    except (EOFError, OSError, zlib.error, UnicodeDecodeError) as error:
        raise UserError(f"{path} cannot be read ({error}): cut short or not such a file") from error
    rows = [line.split() for line in text.splitlines() if line.strip() and line[0] != "#"]
    for number, row in enumerate(rows, start=1):
        if len(row) != num_columns:
            columns = f"{len(row)} column{'' if len(row) == 1 else 's'}"
            what = "cut short or not such a file"
            raise UserError(f"{path}: row {number} has {columns}, not {num_columns}: {what}")
    if len(rows) < 2:
        raise UserError(f"{path} holds {len(rows)} rows: cut short or not such a file")
    try:
        table = np.array(rows, dtype=float)
    except ValueError as error:
        raise UserError(f"{path}: {error}") from error
    if not np.all(np.isfinite(table)):
        raise UserError(f"{path} holds numbers that are not finite")
    return table
