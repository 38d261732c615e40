"""CARMEN logs: FLASER, ROBOTLASER1, ODOM and PARAM lines; plain or gzip.

Which odometry: the second pose of a laser line is the robot's own odometry, the first is the
laser's or, in corrected logs, a pose some SLAM run found; that one is never used as odometry.
Where both are the same and the log has ODOM lines, the odometry is interpolated between those.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.recordings.carmen_lines import (
    SICK_RANGE_MAX_M,
    LaserLine,
    OdomLine,
    parse_flaser,
    parse_odom,
    parse_robotlaser,
)
from grid_mapper.recordings.events import (
    Counts,
    Recording,
    RecordingError,
    RecordingOptions,
    ScanEvent,
)
from grid_mapper.recordings.ordering import StampWatch
from grid_mapper.recordings.pose_track import PoseTrack
from grid_mapper.recordings.text_lines import read_lines
from grid_mapper.scan_cleaning import clean_scan

SAME_POSE_M = 1e-3
REACH_OF_A_ROBOT_M = 1.0
"""A constant offset between the two poses of a line up to this is where the laser sits."""


@dataclass
class CarmenLog:
    """The lines of a log that matter here, in the order of the file."""

    lasers: list[LaserLine] = field(default_factory=list)
    odoms: list[OdomLine] = field(default_factory=list)
    params: dict[str, str] = field(default_factory=dict)
    num_malformed: int = 0
    num_rear: int = 0
    problem: str | None = None

    def add(self, line: str) -> None:
        """Take one line; lines of other kinds are passed over."""
        words = line.split()
        kind = words[0] if words else ""
        try:
            if kind == "FLASER":
                self.lasers.append(parse_flaser(words, self.front_range_max))
            elif kind == "ROBOTLASER1":
                self.lasers.append(parse_robotlaser(words))
            elif kind == "ODOM":
                self.odoms.append(parse_odom(words))
            elif kind == "PARAM" and len(words) >= 3:
                self.params[words[1]] = words[2]
            elif kind in ("RLASER", "ROBOTLASER2"):
                self.num_rear += 1
        except (ValueError, IndexError):
            self.num_malformed += 1

    @property
    def front_range_max(self) -> float:
        """Longest range that is a measurement, m."""
        return float(self.params.get("robot_front_laser_max", SICK_RANGE_MAX_M))


def open_carmen(path: Path, options: RecordingOptions) -> Recording:
    """Open a CARMEN log.

    Raises:
        RecordingError: If there is no laser line, or no odometry though it shall be used.
    """
    log = _read(path)
    if not log.lasers:
        raise RecordingError(f"{path} has no FLASER or ROBOTLASER1 line")
    T_base_laser, laser_info = _laser_pose(log, options)
    track, odom_info = _odometry(path, log, options)
    info = [laser_info, odom_info]
    if log.num_rear:
        info.append(f"{log.num_rear} scans of a rear laser are passed over")

    def source(recording: Recording) -> Iterator[ScanEvent]:
        recording.problem = log.problem
        recording.counts.malformed = log.num_malformed
        yield from _events(log.lasers, T_base_laser, track, recording.counts)

    return Recording("CARMEN log", info, source, num_scans=len(log.lasers))


def _read(path: Path) -> CarmenLog:
    log = CarmenLog()

    def on_problem(text: str) -> None:
        log.problem = text

    for line in read_lines(path, on_problem):
        log.add(line)
    return log


def _events(
    lasers: list[LaserLine], T_base_laser: SE2, track: list[SE2 | None], counts: Counts
) -> Iterator[ScanEvent]:
    watch = StampWatch(counts)
    for line, T_odom_base in zip(lasers, track, strict=True):
        jumped = watch.is_jump(line.stamp_ns)
        scan = clean_scan(line.scan)
        yield ScanEvent(line.stamp_ns, scan, T_base_laser, T_odom_base, jumped)


def _laser_pose(log: CarmenLog, options: RecordingOptions) -> tuple[SE2, str]:
    """Return where the laser sits and the line that says how that is known."""
    if options.laser_pose is not None:
        return options.laser_pose, "laser pose: as given on the command line"
    offset = log.params.get("robot_frontlaser_offset")
    if offset is not None:
        return SE2(float(offset), 0.0, 0.0), f"laser pose: {offset} m ahead, from the log's PARAM"
    offsets = np.array([ln.T_odom_base.between(ln.T_log_laser).as_array() for ln in log.lasers])
    middle = np.median(offsets, axis=0)
    spread = float(np.abs(offsets - middle).max())
    if spread < SAME_POSE_M < np.hypot(middle[0], middle[1]) < REACH_OF_A_ROBOT_M:
        x, y, yaw = (float(value) for value in middle)
        return SE2(x, y, yaw), f"laser pose: ({x:.3f}, {y:.3f}) m, from the two poses of each line"
    return SE2.identity(), (
        "laser pose: the log does not tell it; its poses are taken as the laser's own"
        " (--laser-pose X Y YAW says otherwise)"
    )


def _odometry(
    path: Path, log: CarmenLog, options: RecordingOptions
) -> tuple[list[SE2 | None], str]:
    """Return the odometry at each scan and the line that says where it is from."""
    if not options.use_odom:
        return [None] * len(log.lasers), "odometry: not used, as asked"
    own = [line.T_odom_base for line in log.lasers]
    first_is_other = any(
        line.T_log_laser.between(line.T_odom_base).distance > SAME_POSE_M for line in log.lasers
    )
    if first_is_other:
        return list(own), "odometry: second pose of each laser line"
    note = (
        "; both poses of each line are the same: if this log was corrected by a SLAM run, so is"
        " this odometry (--no-odom maps without it)"
    )
    if log.odoms:
        track = PoseTrack([(o.stamp_ns, o.T_odom_base) for o in log.odoms])
        poses = [track.at(ln.stamp_ns) or ln.T_odom_base for ln in log.lasers]
        return list(poses), "odometry: ODOM lines, interpolated" + note
    if len(own) > 1 and all(pose == own[0] for pose in own):
        raise RecordingError(f"{path} holds no odometry (it never moves): add --no-odom")
    return list(own), "odometry: second pose of each laser line" + note
