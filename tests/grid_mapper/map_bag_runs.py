"""A square room in bags, and map_bag run on them."""

import json

import numpy as np
from recording_builders import (
    NS,
    START_NS,
    range_message,
    scan_message,
    tf_message,
    transform,
    write_bag,
)

from floornav_common.reporting import run_command
from grid_mapper.map_bag import main

HALF_ROOM_M = 3.0
NUM_ROOM_BEAMS = 360
RESULT_FILES = {
    "map.yaml", "map.pgm", "map.png", "trajectory.tum", "summary.json", "report.html",
}  # fmt: skip


def room_ranges(x: float) -> np.ndarray:
    """Return ranges in a square room, seen from (x, 0) without turning."""
    angles = np.linspace(-np.pi, np.pi, NUM_ROOM_BEAMS, endpoint=False)
    c, s = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(c > 0, (HALF_ROOM_M - x) / c, (-HALF_ROOM_M - x) / c)
        to_y = HALF_ROOM_M / np.abs(s)
    return np.minimum(np.abs(to_x), to_y)


def room_bag(path, num_scans=20, storage="mcap", sonar=None, begin=0.0):
    """Write a drive of 0.05 m a scan through the room, with odometry that is right.

    With `sonar` a sonar to the left hears a pane at that distance, which the laser does not see.
    The drive begins `begin` m ahead, so that no scan is one of another drive.
    """
    step_ns = NS // 10
    messages = [
        ("/tf_static", START_NS, tf_message(transform(START_NS, "base_link", "laser"))),
        ("/tf", START_NS, tf_message(transform(START_NS, "odom", "base_link"))),
    ]
    left = tf_message(transform(START_NS, "base_link", "sonar_0", yaw=np.pi / 2.0))
    messages += [] if sonar is None else [("/tf_static", START_NS, left)]
    for i in range(num_scans):
        stamp_ns, x = START_NS + i * step_ns, 0.05 * i
        scan = scan_message(stamp_ns, room_ranges(begin + x))
        scan.angle_min, scan.angle_increment = -np.pi, 2 * np.pi / NUM_ROOM_BEAMS
        odom = tf_message(transform(stamp_ns, "odom", "base_link", x=x))
        messages += [("/scan", stamp_ns + 1, scan), ("/tf", stamp_ns + 2, odom)]
        if sonar is not None:
            messages.append(("/sonar", stamp_ns + 3, range_message(stamp_ns, sonar)))
    return write_bag(path, messages, storage)


def run(*args) -> int:
    """Return the exit code of map_bag with these words."""
    return run_command(lambda: main([str(arg) for arg in args]))


def summary_of(folder):
    """Return what map_bag measured."""
    return json.loads((folder / "summary.json").read_text())
