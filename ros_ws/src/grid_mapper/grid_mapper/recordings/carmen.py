"""CARMEN logs: FLASER, ROBOTLASER1, RAWLASER1, ODOM and PARAM lines; plain or gzip.

Which odometry: the second pose of a laser line is the robot's own odometry, the first is the
laser's or, in corrected logs, a pose some SLAM run found; that one is never used as odometry.
Where both are the same and the log has ODOM lines, the odometry is interpolated between those.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.recordings.carmen_lines import (
    SICK_RANGE_MAX_M,
    LaserLine,
    OdomLine,
    parse_flaser,
    parse_odom,
    parse_rawlaser,
    parse_robotlaser,
)
from grid_mapper.recordings.carmen_ranges import fan_info, range_limits
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
PARSERS: dict[str, Callable[[list[str]], LaserLine]] = {
    "FLASER": lambda words: parse_flaser(words, SICK_RANGE_MAX_M),
    "ROBOTLASER1": parse_robotlaser,
    "RAWLASER1": parse_rawlaser,
}
"""By kind of line; where a log holds a scan in several, the first of these counts."""
REAR_KINDS = ("RLASER", "ROBOTLASER2", "RAWLASER2")
CARMEN_KINDS = ("ODOM", "PARAM", *PARSERS, *REAR_KINDS)


@dataclass
class CarmenLog:
    """The lines of a log that matter here, in the order of the file."""

    lasers_by_kind: dict[str, list[LaserLine]] = field(default_factory=dict)
    odoms: list[OdomLine] = field(default_factory=list)
    params: dict[str, str] = field(default_factory=dict)
    malformed_by_kind: dict[str, int] = field(default_factory=dict)
    num_rear: int = 0
    problem: str | None = None

    def add(self, line: str) -> None:
        """Take one line; lines of other kinds are passed over."""
        words = line.split()
        kind = words[0] if words else ""
        try:
            if kind in PARSERS:
                self.lasers_by_kind.setdefault(kind, []).append(PARSERS[kind](words))
            elif kind == "ODOM":
                self.odoms.append(parse_odom(words))
            elif kind == "PARAM" and len(words) >= 3:
                self.params[words[1]] = words[2]
            elif kind in REAR_KINDS:
                self.num_rear += 1
        except (ValueError, IndexError, OverflowError):
            self.malformed_by_kind[kind] = self.malformed_by_kind.get(kind, 0) + 1

    @property
    def kind(self) -> str:
        """Kind of laser line that is used: the one with most lines, the earlier one if equal."""
        return max(PARSERS, key=lambda kind: len(self.lasers_by_kind.get(kind, [])))

    @property
    def lasers(self) -> list[LaserLine]:
        """The laser lines that are used."""
        return self.lasers_by_kind.get(self.kind, [])


def open_carmen(path: Path, options: RecordingOptions) -> Recording:
    """Open a CARMEN log.

    Raises:
        RecordingError: If there is no laser line, or no odometry though it shall be used.
    """
    log = _read(path)
    if not log.lasers:
        raise RecordingError(f"{path} has {_what_it_has(log)}")
    T_base_laser, laser_info = _laser_pose(path, log, options)
    track, odom_info = _odometry(path, log, options)
    limits, range_info = range_limits(path, log.lasers, log.params, options)
    kinds = {kind: len(lines) for kind, lines in log.lasers_by_kind.items() if kind != log.kind}
    info = [f"scans: {log.kind} lines, {fan_info(log.kind, log.lasers[0])}"]
    info += [f"scans: {n} {kind} lines are passed over" for kind, n in kinds.items() if n]
    info += [laser_info, odom_info, range_info]
    if log.num_rear:
        info.append(f"{log.num_rear} scans of a rear laser are passed over")

    def source(recording: Recording) -> Iterator[ScanEvent]:
        recording.problem = log.problem
        recording.counts.malformed = sum(log.malformed_by_kind.values())
        yield from _events(log.lasers, limits, T_base_laser, track, recording.counts)

    return Recording("CARMEN log", info, source, num_scans=len(log.lasers))


def _what_it_has(log: CarmenLog) -> str:
    num_bad = sum(n for kind, n in log.malformed_by_kind.items() if kind in PARSERS)
    if num_bad:
        return f"{num_bad} laser lines, none of which can be read"
    if log.num_rear:
        return f"scans of a rear laser only ({log.num_rear} lines), which are not mapped"
    return f"no {' or '.join(PARSERS)} line"


def _read(path: Path) -> CarmenLog:
    log = CarmenLog()

    def on_problem(text: str) -> None:
        log.problem = text

    for line in read_lines(path, on_problem):
        log.add(line)
    return log


def _events(
    lasers: list[LaserLine],
    limits: tuple[float, float],
    T_base_laser: SE2,
    track: dict[int, SE2 | None],
    counts: Counts,
) -> Iterator[ScanEvent]:
    watch = StampWatch(counts)
    has_jumped = False
    for i, line in enumerate(lasers):
        has_jumped |= watch.is_jump(line.stamp_ns)
        if i not in track:
            counts.without_transform += 1
            continue
        scan = clean_scan(replace(line.scan, range_min=limits[0], range_max=limits[1]))
        yield ScanEvent(line.stamp_ns, scan, T_base_laser, track[i], has_jumped)
        has_jumped = False


def _laser_pose(path: Path, log: CarmenLog, options: RecordingOptions) -> tuple[SE2, str]:
    """Return where the laser sits and the line that says how that is known."""
    if options.laser_pose is not None:
        return options.laser_pose, "laser pose: as given on the command line"
    offset = log.params.get("robot_frontlaser_offset")
    if offset is not None:
        try:
            return SE2(float(offset), 0.0, 0.0), f"laser pose: {offset} m ahead, the log's PARAM"
        except ValueError:
            raise RecordingError(
                f"{path}: PARAM robot_frontlaser_offset {offset} is no number: say where the laser"
                " sits with --laser-pose X Y YAW (m, m, rad)"
            ) from None
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
) -> tuple[dict[int, SE2 | None], str]:
    """Return the odometry by number of the scan, and the line that says where it is from."""
    numbers = range(len(log.lasers))
    if not options.use_odom:
        return dict.fromkeys(numbers), "odometry: not used, as asked"
    own: dict[int, SE2 | None] = {i: log.lasers[i].T_odom_base for i in numbers}
    first_is_other = any(
        line.T_log_laser.between(line.T_odom_base).distance > SAME_POSE_M for line in log.lasers
    )
    if first_is_other:
        return own, "odometry: second pose of each laser line"
    note = (
        "; both poses of each line are the same: if this log was corrected by a SLAM run, so is"
        " this odometry (--no-odom maps without it)"
    )
    has_poses = log.lasers[0].has_poses
    moves = has_poses and (len(own) == 1 or any(pose != own[0] for pose in own.values()))
    track = PoseTrack([(o.stamp_ns, o.T_odom_base) for o in log.odoms])
    between = {i: pose for i in numbers if (pose := track.at(log.lasers[i].stamp_ns)) is not None}
    if between:
        info = "odometry: ODOM lines, interpolated"
        return {**(own if moves else {}), **between}, info + (note if moves else "")
    if not moves:
        unused = " in the time of its scans" if log.odoms else ""
        raise RecordingError(f"{path} holds no odometry{unused} (it never moves): add --no-odom")
    return own, "odometry: second pose of each laser line" + note
