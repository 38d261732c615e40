"""The ways that recordings bring with them, to compare ours with: odometry, published poses."""

from __future__ import annotations

from pathlib import Path

from floornav_common.reporting import say
from floornav_common.se2 import SE2
from grid_mapper.recordings import ScanEvent, open_recording
from grid_mapper.recordings.carmen_lines import parse_robotlaser
from grid_mapper.recordings.ordering import seconds_to_ns
from grid_mapper.recordings.text_lines import read_lines
from grid_mapper.trajectory_metrics import Trajectory


def odometry(path: Path) -> Trajectory:
    """Return the odometry of a recording, as far as its scans have one."""
    events = (e for e in open_recording(path).events() if isinstance(e, ScanEvent))
    return [(e.stamp_ns, e.T_odom_base) for e in events if e.T_odom_base is not None]


def published_poses(path: Path) -> Trajectory:
    """Return the corrected poses: the first of a FLASER line, or of each VERTEX2 with a scan."""
    poses = []
    vertex = SE2.identity()
    for line in read_lines(path, say):
        words = line.split()
        kind = words[0] if words else ""
        if kind == "FLASER":
            after = words[2 + int(words[1]) :]
            poses.append((seconds_to_ns(after[6]), SE2(*(float(w) for w in after[:3]))))
        elif kind == "VERTEX2":
            vertex = SE2(*(float(w) for w in words[2:5]))
        elif kind == "ROBOTLASER1":
            poses.append((parse_robotlaser(words).stamp_ns, vertex))
    return poses
