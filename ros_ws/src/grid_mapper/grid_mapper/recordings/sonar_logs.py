"""Text logs of sonars without a laser.

- Eight sonars with poses: `measurement.txt` (time ms, 8 ranges mm) beside `poses.txt` (time ms, x,
  y mm, heading 0.1 deg), a row a step; 5110 mm = no echo. About half of the sonars are measured
  anew in a row, the others repeat the row before; which is not recorded.
- SCITOS ring of 24 sonars: CSV with header `S1,..,S24,OUTPUT`; S1 looks ahead, numbers go
  clockwise; m, 9 rows a second, 5.0 = no echo. It has no poses.

Neither says where on the robot its sonars sit or how wide they look: they are taken to sit at the
robot's center, and their opening is left unsaid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

from floornav_common.se2 import SE2
from grid_mapper.recordings.events import (
    RangeEvent,
    Recording,
    RecordingError,
    RecordingOptions,
)
from grid_mapper.recordings.log_entries import read_words

EIGHT_RANGES, EIGHT_POSES = "measurement.txt", "poses.txt"
EIGHT_BEARINGS_DEG = (-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0)
EIGHT_MAX_M = 5.11
M_PER_MM, NS_PER_MS = 1e-3, 1_000_000
RING_SIZE, RING_MAX_M = 24, 5.0
RING_PERIOD_NS = 1_000_000_000 // 9
RING_HEAD = ",".join([*(f"S{k}" for k in range(1, RING_SIZE + 1)), "OUTPUT"])


@dataclass(frozen=True)
class _Row:
    """Ranges of all sonars at one stamp, and the robot's pose if the log has it."""

    stamp_ns: int
    ranges: tuple[float, ...]
    pose: SE2 | None


def eight_sonars_file(path: Path) -> Path | None:
    """Return the file of ranges if a path (it, or its folder) is a log of eight sonars."""
    file = path / EIGHT_RANGES if path.is_dir() else path
    is_one = file.name == EIGHT_RANGES and (file.parent / EIGHT_POSES).is_file() and file.is_file()
    return file if is_one else None


def is_sonar_ring(words: list[str]) -> bool:
    """Tell whether a line is the head of a SCITOS log."""
    return words == [RING_HEAD]


def open_eight_sonars(path: Path, options: RecordingOptions) -> Recording:
    """Open `measurement.txt`; the poses beside it are taken as they are.

    Raises:
        RecordingError: If there is no row with a pose, or poses shall not be used.
    """
    if not options.use_odom:
        raise RecordingError(f"{path}: the poses in {EIGHT_POSES} are what it is mapped by")
    ranges, poses = _numbers(path, 9), _numbers(path.parent / EIGHT_POSES, 4)
    pose_at = {
        round(t): SE2(x * M_PER_MM, y * M_PER_MM, radians(0.1 * heading))
        for t, x, y, heading in poses.rows
    }
    rows = [
        _Row(round(t) * NS_PER_MS, tuple(M_PER_MM * v for v in values), pose_at[round(t)])
        for t, *values in ranges.rows
        if round(t) in pose_at
    ]
    num_unplaced = len(ranges.rows) - len(rows)
    yaws = [radians(bearing) for bearing in EIGHT_BEARINGS_DEG]
    return _recording(
        "log of eight sonars", path, rows, yaws, EIGHT_MAX_M, f"poses: {EIGHT_POSES}, as they are",
        ranges.num_malformed + poses.num_malformed, num_unplaced, ranges.problem or poses.problem,
    )  # fmt: skip


def open_sonar_ring(path: Path, options: RecordingOptions) -> Recording:
    """Open a SCITOS log; it has no poses, so the user has to say that none are wanted.

    Raises:
        RecordingError: If there is no row, or odometry is wanted.
    """
    if options.use_odom:
        raise RecordingError(
            f"{path} has no poses: --no-odom takes the robot as standing still, which only shows"
            " what its sonars say"
        )
    log = _numbers(path, RING_SIZE)
    rows = [_Row((k + 1) * RING_PERIOD_NS, row, None) for k, row in enumerate(log.rows)]
    yaws = [-2.0 * pi * k / RING_SIZE for k in range(RING_SIZE)]
    info = "poses: none, the robot is taken as standing still, as asked"
    num_malformed = log.num_malformed - 1  # the head
    return _recording(
        "SCITOS log", path, rows, yaws, RING_MAX_M, info, num_malformed, 0, log.problem
    )


@dataclass(frozen=True)
class _Numbers:
    """Rows of numbers, how many lines are none, and why reading stopped early."""

    rows: list[tuple[float, ...]]
    num_malformed: int
    problem: str | None


def _numbers(path: Path, num: int) -> _Numbers:
    """Return the first `num` columns of each line that has them."""
    rows: list[tuple[float, ...]] = []
    text = read_words(path)
    for words in (" ".join(words).replace(",", " ").split() for words in text.lines):
        try:
            row = tuple(float(word) for word in words[:num])
        except ValueError:
            continue
        if len(row) == num:
            rows.append(row)
    return _Numbers(rows, len(text.lines) - len(rows), text.problem)


def _recording(
    name: str,
    path: Path,
    rows: Sequence[_Row],
    yaws: Sequence[float],
    max_range: float,
    pose_info: str,
    num_malformed: int,
    num_unplaced: int,
    problem: str | None,
) -> Recording:
    if not rows:
        raise RecordingError(f"{path} has no readable row with a pose ({name})")

    def source(recording: Recording) -> Iterator[RangeEvent]:
        counts, recording.problem = recording.counts, problem
        counts.malformed, counts.without_transform = num_malformed, num_unplaced
        for row in rows:
            for k, (value, yaw) in enumerate(zip(row.ranges, yaws, strict=True), 1):
                yield RangeEvent(
                    row.stamp_ns, f"sonar_{k}", value, 0.0, max_range, 0.0, SE2(0.0, 0.0, yaw),
                    row.pose,
                )  # fmt: skip

    info = [f"sonars: {len(yaws)}, at the robot's center, opening not recorded", pose_info]
    return Recording(name, info, source, num_scans=0)
