"""What the readers of small text logs share: entries to events, with stamps watched."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.events import (
    Recording,
    RecordingError,
    RecordingOptions,
    ScanEvent,
)
from grid_mapper.recordings.ordering import StampWatch
from grid_mapper.recordings.text_lines import read_lines
from grid_mapper.scan_cleaning import clean_scan


@dataclass(frozen=True)
class LogEntry:
    """A scan of a text log with the odometry that the log has for it."""

    stamp_ns: int
    scan: Scan
    T_odom_base: SE2 | None


@dataclass(frozen=True)
class LogText:
    """A log's lines as words, and why reading stopped early (None if it did not)."""

    lines: list[list[str]]
    problem: str | None


def read_words(path: Path) -> LogText:
    """Read all lines of a log as words; empty lines are left out."""
    problems: list[str] = []
    lines = [words for line in read_lines(path, problems.append) if (words := line.split())]
    return LogText(lines, problems[0] if problems else None)


def limited(scan: Scan, options: RecordingOptions) -> Scan:
    """Return the scan with the limits of its ranges that the user gave, if any."""
    if options.range_limits_m is None:
        return scan
    low, high = options.range_limits_m
    return replace(scan, range_min=low, range_max=high)


def log_recording(
    format_name: str,
    path: Path,
    entries: Sequence[LogEntry],
    laser: tuple[SE2, str],
    odom_info: str,
    options: RecordingOptions,
    num_malformed: int,
    problem: str | None,
) -> Recording:
    """Return the recording of a text log that is read already.

    Args:
        format_name: Name of the format for the user.
        path: The log, for messages.
        entries: Its scans in the order of the file.
        laser: Where the log says the laser sits, and how it is known.
        odom_info: Where the odometry is from.
        options: What the user says; a laser pose there beats the log's.
        num_malformed: Lines that could not be read.
        problem: Why reading stopped early.

    Raises:
        RecordingError: If there is no scan.
    """
    if not entries:
        raise RecordingError(f"{path} has no readable scan ({format_name})")
    T_base_laser, laser_info = laser
    if options.laser_pose is not None:
        T_base_laser, laser_info = options.laser_pose, "as given on the command line"
    if not options.use_odom:
        odom_info = "not used, as asked"

    def source(recording: Recording) -> Iterator[ScanEvent]:
        recording.problem = problem
        recording.counts.malformed = num_malformed
        watch = StampWatch(recording.counts)
        for entry in entries:
            jumped = watch.is_jump(entry.stamp_ns)
            T_odom_base = entry.T_odom_base if options.use_odom else None
            scan = clean_scan(limited(entry.scan, options))
            yield ScanEvent(entry.stamp_ns, scan, T_base_laser, T_odom_base, jumped)

    info = [f"laser pose: {laser_info}", f"odometry: {odom_info}"]
    return Recording(format_name, info, source, num_scans=len(entries))
