"""Logs of the Mines ParisTech rover (CoreSLAM): wheel ticks and a Hokuyo scan a line.

707 columns: time (us), one unknown, left and right ticks (running counts), 20 unknown, 682 ranges
(mm, 0 = no return) over 240 degrees from -120 degrees, one trailing.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.events import Recording, RecordingOptions, WheelOptions
from grid_mapper.recordings.log_entries import LogEntry, log_recording, read_words

NUM_WORDS = 707
RANGES = slice(24, 706)
NUM_BEAMS = 682
NS_PER_US = 1_000
M_PER_MM = 1e-3
FOV_RAD = np.deg2rad(240.0)
RANGE_MIN_M = 0.02
RANGE_MAX_M = 5.6
"""Reach of the URG-04LX."""
LASER_AHEAD_M = 0.145


def is_mines_rover(words: list[str]) -> bool:
    """Tell whether a line is one of this format."""
    return len(words) == NUM_WORDS and all(word.lstrip("-").isdigit() for word in words[:4])


def open_mines_rover(path: Path, options: RecordingOptions) -> Recording:
    """Open a rover log; the odometry is dead reckoning from the wheel ticks.

    Raises:
        RecordingError: If there is no scan.
    """
    text = read_words(path)
    rows: list[np.ndarray] = []
    num_malformed = 0
    for words in text.lines:
        try:
            row = np.array(words, dtype=np.float64)
        except ValueError:
            row = np.empty(0)
        if len(row) == NUM_WORDS:
            rows.append(row)
        else:
            num_malformed += 1
    poses = dead_reckoning(np.array([row[2:4] for row in rows]), options.wheels) if rows else []
    entries = [
        LogEntry(int(row[0]) * NS_PER_US, _scan(row), pose)
        for row, pose in zip(rows, poses, strict=True)
    ]
    laser = (SE2(LASER_AHEAD_M, 0.0, 0.0), f"{LASER_AHEAD_M} m ahead, as the log's source has it")
    w = options.wheels
    odom_info = (
        f"dead reckoning from wheel ticks ({w.ticks_per_turn:g} ticks a turn, wheel radius"
        f" {w.wheel_radius_m:g} m, half axle {w.half_axle_m:g} m)"
    )
    return log_recording(
        "rover log", path, entries, laser, odom_info, options, num_malformed, text.problem
    )


def dead_reckoning(ticks: np.ndarray, wheels: WheelOptions) -> list[SE2]:
    """Return the poses that counted wheel ticks lead to, from the origin.

    Args:
        ticks: Left and right running counts, shape (N, 2).
        wheels: Geometry of the wheels.

    Returns:
        N poses; between two the robot drives an arc.
    """
    meters_per_tick = 2.0 * np.pi * wheels.wheel_radius_m / wheels.ticks_per_turn
    steps = np.diff(ticks, axis=0) * meters_per_tick
    poses = [SE2.identity()]
    for left, right in steps:
        poses.append(poses[-1] @ arc(float(left), float(right), wheels.half_axle_m))
    return poses


def arc(left: float, right: float, half_axle: float) -> SE2:
    """Return the motion of a two-wheeled robot whose wheels rolled `left` and `right`, m."""
    forward, turn = 0.5 * (left + right), 0.5 * (right - left) / half_axle
    chord = forward * float(np.sinc(turn / (2.0 * np.pi)))
    return SE2(chord * float(np.cos(turn / 2.0)), chord * float(np.sin(turn / 2.0)), turn)


def _scan(row: np.ndarray) -> Scan:
    step = float(FOV_RAD) / (NUM_BEAMS - 1)
    return Scan(M_PER_MM * row[RANGES], -float(FOV_RAD) / 2.0, step, RANGE_MIN_M, RANGE_MAX_M)
