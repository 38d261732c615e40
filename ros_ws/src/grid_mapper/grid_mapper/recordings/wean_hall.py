"""Logs of the CMU robot course (Wean Hall): `O` and `L` lines in centimeters.

`O x y theta t` and `L x y theta xl yl thetal r1 .. r180 t`: robot pose and laser pose in the raw
odometry frame, ranges in cm from -90 degrees in steps of 1 degree.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.carmen_lines import SICK_RANGE_MAX_M
from grid_mapper.recordings.events import Recording, RecordingOptions
from grid_mapper.recordings.log_entries import LogEntry, log_recording, read_words
from grid_mapper.recordings.ordering import seconds_to_ns

M_PER_CM = 0.01
NUM_BEAMS = 180
NUM_WORDS = {"L": 1 + 6 + NUM_BEAMS + 1, "O": 1 + 3 + 1}


def is_wean_hall(words: list[str]) -> bool:
    """Tell whether a line is one of this format."""
    return bool(words) and NUM_WORDS.get(words[0]) == len(words)


def open_wean_hall(path: Path, options: RecordingOptions) -> Recording:
    """Open a Wean Hall log.

    Raises:
        RecordingError: If there is no scan.
    """
    text = read_words(path)
    entries: list[LogEntry] = []
    mounts: list[SE2] = []
    num_malformed = 0
    for words in text.lines:
        if words[0] != "L":
            continue
        try:
            entry, T_base_laser = _parse(words)
        except ValueError:
            num_malformed += 1
            continue
        entries.append(entry)
        mounts.append(T_base_laser)
    laser = _middle(mounts)
    info = f"({laser.x:.3f}, {laser.y:.3f}) m, from the two poses of the L lines"
    return log_recording(
        "Wean Hall log", path, entries, (laser, info), "robot pose of each L line", options,
        num_malformed, text.problem,
    )  # fmt: skip


def _parse(words: list[str]) -> tuple[LogEntry, SE2]:
    if len(words) != NUM_WORDS["L"]:
        raise ValueError(f"an L line has {NUM_WORDS['L']} words, got {len(words)}")
    values = np.array(words[1:-1], dtype=np.float64)
    T_odom_base, T_odom_laser = (
        SE2(M_PER_CM * float(x), M_PER_CM * float(y), float(yaw))
        for x, y, yaw in (values[:3], values[3:6])
    )
    scan = Scan(M_PER_CM * values[6:], -np.pi / 2.0, np.pi / NUM_BEAMS, 0.0, SICK_RANGE_MAX_M)
    entry = LogEntry(seconds_to_ns(words[-1]), scan, T_odom_base)
    return entry, T_odom_base.between(T_odom_laser)


def _middle(poses: list[SE2]) -> SE2:
    """Return the median pose, rounded to 0.1 mm, which the log's digits carry."""
    if not poses:
        return SE2.identity()
    x, y, yaw = (round(float(v), 4) for v in np.median([p.as_array() for p in poses], axis=0))
    return SE2(x, y, yaw)
