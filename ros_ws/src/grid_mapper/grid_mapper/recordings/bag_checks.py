"""What must hold before a bag is mapped: scans that are scans, one clock, a laser that is level."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import TransformBuffer, TransformUnavailable
from grid_mapper.laser_mount import level_scan
from grid_mapper.recordings.bag_frames import fixed_links, plain
from grid_mapper.recordings.bag_survey import Span, Survey
from grid_mapper.recordings.events import RecordingError, RecordingOptions
from grid_mapper.recordings.scan_geometry import angle_note, scan_of

NS = 1e-9
OTHER_CLOCK_NS = 2_000_000_000
"""Messages of one clock are recorded so near to each other; farther all the time are two clocks."""
NUM_LAGS_NEEDED = 5


def check_scans(path: Path, topic: str, found: Survey, options: RecordingOptions) -> list[str]:
    """Return what is odd about the scans and was settled.

    Raises:
        RecordingError: If none can be used.
    """
    first = found.first.get(topic)
    if first is None:
        raise RecordingError(f"{path}: no message on {topic} holds a scan that can be read")
    try:
        scan_of(first, options.range_limits_m)
    except ValueError as error:
        raise RecordingError(f"{path}: the first scan on {topic} has {error}") from error
    span = found.spans[topic]
    if span.num == 0 and not options.use_recorded_stamps:
        raise RecordingError(
            f"{path}: all scans on {topic} are stamped 0: take the times at which they were"
            " recorded with --recorded-stamps"
        )
    notes = [f"scans: {note}" for note in [angle_note(first)] if note]
    if span.num_zero and not options.use_recorded_stamps:
        notes.append(f"scans: {span.num_zero} are stamped 0 and left out (--recorded-stamps)")
    if options.use_recorded_stamps:
        notes.append("stamps: the times of recording, as asked")
    return notes


def laser_info(
    path: Path, found: Survey, topic: str, base: str, is_described: bool, options: RecordingOptions
) -> str:
    """Return where the pose of the laser is from.

    Raises:
        RecordingError: If it is not known, or the laser is not level.
    """
    frame, tree = plain(found.first[topic].header.frame_id), found.tree
    if options.laser_pose is not None:
        return f"laser pose: as given on the command line{_overridden(found, base, frame)}"
    cure = "say where the laser sits on the robot with --laser-pose X Y YAW (m, m, rad)"
    if not frame:
        raise RecordingError(f"{path}: scans on {topic} name no frame_id: {cure}")
    if not tree.connects(base, frame):
        raise RecordingError(f"{path} has no transform from {base} to {frame}: {cure}")
    _check_level(path, found, topic, base, options)
    if is_described:
        return f"laser pose: fixed joints of robot_description, {base} -> {frame}"
    links = tree.between(base, frame)
    is_fixed = all(link.is_static or link.is_constant for link in links)
    unsent = is_fixed and not all(link.is_static for link in links)
    note = ", sent as moving but always the same: taken as static" if unsent else ""
    return f"laser pose: TF {base} -> {frame}{note}"


def _overridden(found: Survey, base: str, frame: str) -> str:
    """Return what TF says of a laser whose pose is given; "" if TF does not know it."""
    if not frame or frame == base or not found.tree.connects(base, frame):
        return ""
    pose = _fixed_pose(found, base, frame)
    if pose is None:
        return f" (instead of TF {base} -> {frame}, which moves)"
    x, y, _ = pose.translation
    return f" (instead of TF {base} -> {frame}: {x:.3f} {y:.3f} {pose.to_se2().yaw:.4f})"


def _fixed_pose(found: Survey, base: str, frame: str) -> Transform3 | None:
    """Return where a frame sits on the robot by what never moves; None if that does not say."""
    buffer = TransformBuffer()
    try:
        for parent, child, stamp_ns, xyz, quat in fixed_links(found.tree, base).values():
            buffer.set_transform(parent, child, stamp_ns, xyz, quat, is_static=True)
        return buffer.lookup(base, frame)
    except (TransformUnavailable, ValueError):
        return None


def _check_level(
    path: Path, found: Survey, topic: str, base: str, options: RecordingOptions
) -> None:
    """Refuse a laser that is mounted at a tilt; one that moves is judged scan by scan."""
    first = found.first[topic]
    pose = _fixed_pose(found, base, first.header.frame_id)
    if pose is None:
        return
    try:
        level_scan(scan_of(first, options.range_limits_m), pose)
    except ValueError as error:
        raise RecordingError(f"{path}: {error}, or give --laser-pose X Y YAW") from error


def check_clocks(
    path: Path,
    found: Survey,
    scan_topic: str,
    odom_topic: str | None,
    odom_frame: str | None,
    base: str,
    options: RecordingOptions,
) -> list[str]:
    """Return a line if scans and odometry seem to be stamped by two clocks.

    Raises:
        RecordingError: If they share no time at all.
    """
    scans, odom = found.spans[scan_topic], _odometry_span(found, odom_topic, odom_frame, base)
    if odom is None or options.use_recorded_stamps:
        return []
    text = (
        f"scans are stamped {scans.oldest_ns * NS:.1f} to {scans.newest_ns * NS:.1f} s, odometry"
        f" {odom.oldest_ns * NS:.1f} to {odom.newest_ns * NS:.1f} s"
    )
    cure = "--recorded-stamps takes the times of recording for both"
    if not scans.overlaps(odom):
        raise RecordingError(f"{path}: {text}: two clocks? {cure}, --no-odom maps without odometry")
    lag_ns = _steady_lag_ns(scans, odom)
    if abs(lag_ns) > OTHER_CLOCK_NS * max(1.0, scans.speed, odom.speed):
        return [
            f"stamps: scans are stamped {abs(lag_ns) * NS:.1f} s"
            f" {'behind' if lag_ns < 0 else 'ahead of'} the odometry recorded just before them: if"
            f" these are two clocks, {cure}"
        ]
    return []


def _steady_lag_ns(scans: Span, odom: Span) -> float:
    """Return how far scans are from the odometry recorded before them; 0 if that varies.

    The speed of the recorder's clock does not matter to it, as a simulator's or a replay's.
    """
    if len(odom.lags_ns) < NUM_LAGS_NEEDED or scans.num < NUM_LAGS_NEEDED:
        return 0.0
    low, middle, high = np.quantile(odom.lags_ns, (0.1, 0.5, 0.9))
    return float(middle) if high - low < abs(middle) / 2.0 else 0.0


def _odometry_span(
    found: Survey, odom_topic: str | None, odom_frame: str | None, base: str
) -> Span | None:
    """Return the stamps of what gives the odometry; None if nothing that is stamped does."""
    if odom_topic is not None:
        return found.spans[odom_topic] if found.spans[odom_topic].num else None
    if odom_frame is None:
        return None
    moving = [link for link in found.tree.between(odom_frame, base) if not link.is_static]
    spans = [link.span for link in moving if link.span.num]
    return min(spans, key=lambda span: span.newest_ns - span.oldest_ns, default=None)
