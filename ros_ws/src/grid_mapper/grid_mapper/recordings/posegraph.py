"""Pose-graph logs: VERTEX2 with a ROBOTLASER1 each, and EDGE2 between the vertices.

The vertex poses, and the poses inside the ROBOTLASER1 lines, are the result of someone's SLAM
run: they are never read as odometry, for what is evaluated against them would be fed with them.
The odometry is the chain of the sequential EDGE2 (vertex i to i + 1): incremental scan matching by
the log's authors, which drifts. Without it (`--no-odom`) only the scans are used.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from floornav_common.se2 import SE2
from grid_mapper.recordings.carmen_lines import LaserLine, parse_robotlaser
from grid_mapper.recordings.events import Recording, RecordingError, RecordingOptions
from grid_mapper.recordings.log_entries import LogEntry, log_recording, read_words

SEQUENTIAL_INFO = (
    "chain of the sequential EDGE2, which is the authors' incremental scan matching;"
    " vertex poses are not used"
)


def open_posegraph(path: Path, options: RecordingOptions) -> Recording:
    """Open a pose-graph log.

    Raises:
        RecordingError: If there is no scan, or the chain of edges is broken.
    """
    text = read_words(path)
    lasers: dict[int, LaserLine] = {}
    edges: dict[tuple[int, int], SE2] = {}
    vertex = -1
    num_malformed = 0
    for words in text.lines:
        try:
            if words[0] == "VERTEX2":
                vertex = int(words[1])
            elif words[0] == "ROBOTLASER1":
                lasers[vertex] = parse_robotlaser(words)
            elif words[0] == "EDGE2":
                pair = (int(words[1]), int(words[2]))
                edges.setdefault(pair, SE2(*(float(word) for word in words[3:6])))
        except (ValueError, IndexError, TypeError):
            num_malformed += 1
    poses = _chain(text.problem, path, sorted(lasers), edges) if options.use_odom else {}
    entries = [
        LogEntry(line.stamp_ns, line.scan, poses.get(i)) for i, line in sorted(lasers.items())
    ]
    laser = _laser_pose(list(lasers.values()))
    return log_recording(
        "pose-graph log", path, entries, laser, SEQUENTIAL_INFO, options,
        num_malformed, text.problem,
    )  # fmt: skip


def _chain(
    problem: str | None, path: Path, ids: list[int], edges: dict[tuple[int, int], SE2]
) -> dict[int, SE2]:
    """Return the pose of each vertex by the sequential edges, from the first vertex."""
    poses = {ids[0]: SE2.identity()} if ids else {}
    for before, after in zip(ids, ids[1:], strict=False):
        if (before, after) in edges:
            step = edges[before, after]
        elif (after, before) in edges:
            step = edges[after, before].inverse()
        else:
            raise RecordingError(
                f"{path}: {f'{problem}; ' if problem else ''}no EDGE2 from vertex {before} to"
                f" {after}, so there is no odometry: map without with --no-odom"
            )
        poses[after] = poses[before] @ step
    return poses


def _laser_pose(lines: list[LaserLine]) -> tuple[SE2, str]:
    """Return where the laser sits: the difference of the two poses of a ROBOTLASER1 line."""
    if not lines:
        return SE2.identity(), ""
    T_base_laser = lines[0].T_odom_base.between(lines[0].T_log_laser)
    pose = replace(T_base_laser, x=round(T_base_laser.x, 4), y=round(T_base_laser.y, 4))
    return pose, f"({pose.x:.3f}, {pose.y:.3f}) m, from the ROBOTLASER1 lines"
