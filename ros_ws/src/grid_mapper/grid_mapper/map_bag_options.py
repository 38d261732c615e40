"""Options of `map_bag` that say what of a recording is used, how, and what it is compared with."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from floornav_common.arguments import finite, not_negative, positive
from floornav_common.frames import FrameConfig
from floornav_common.se2 import SE2
from grid_mapper.map_results import MapInputs
from grid_mapper.recordings import RecordingOptions
from grid_mapper.recordings.events import WheelOptions
from grid_mapper.relations import load_relations
from grid_mapper.trajectory_metrics import load_tum

T = TypeVar("T")
RELATIONS_TOL_S = 0.002
ENDINGS = (".gz", ".zstd", ".log", ".dat", ".db3", ".mcap", ".bag")


def add_input_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to a parser."""
    group = parser.add_argument_group("what of the recording is used")
    add = group.add_argument
    add("--list", action="store_true", help="show topics, types and rates, and map nothing")
    add("--scan-topic", metavar="TOPIC", help="LaserScan topic (default: the only one, or /scan)")
    add("--odom-topic", metavar="TOPIC", help="odometry from this topic instead of TF")
    add("--sonar-topic", metavar="TOPIC", action="append", default=[],
        help="Range topic of ultrasonic sensors; may be given again")  # fmt: skip
    add("--sonar-pose", nargs=4, metavar=("FRAME", "X", "Y", "YAW"), action="append", default=[],
        help="where the sonar of a frame sits on the robot (m, m, rad); one a frame")  # fmt: skip
    add("--laser-pose", type=finite, nargs=3, metavar=("X", "Y", "YAW"),
        help="where the laser sits on the robot (m, m, rad)")  # fmt: skip
    add("--no-odom", action="store_true", help="map without odometry")
    add("--base-frame", metavar="FRAME",
        help="frame of the robot (default: base_link, or what a bag has instead)")  # fmt: skip
    add("--odom-frame", metavar="FRAME",
        help="frame of the odometry (default: odom, or what a bag has instead)")  # fmt: skip
    add("--range-limits", type=not_negative, nargs=2, metavar=("MIN", "MAX"),
        help="shortest and longest range that is a measurement (m, m)")  # fmt: skip
    add("--recorded-stamps", action="store_true",
        help="take the times of recording instead of a bag's stamps")  # fmt: skip
    wheels = WheelOptions()
    add("--ticks-per-turn", type=positive, default=wheels.ticks_per_turn, metavar="N",
        help="for logs of wheel ticks: ticks of a wheel turn (default: %(default)s)")  # fmt: skip
    add("--wheel-radius", type=positive, default=wheels.wheel_radius_m, metavar="M",
        help="for logs of wheel ticks (default: %(default)s m)")  # fmt: skip
    add("--half-axle", type=positive, default=wheels.half_axle_m, metavar="M",
        help="for logs of wheel ticks (default: %(default)s m)")  # fmt: skip


def add_comparison_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what the result is compared with."""
    add = parser.add_argument
    add("--relations", type=Path, metavar="FILE", help="known relations: t1 t2 x y z r p yaw")
    add("--relations-tol", type=not_negative, metavar="S",
        help=f"how far a relation's stamp may be from a pose (default: {RELATIONS_TOL_S} s)",
        )  # fmt: skip
    add("--relations-offset", type=finite, metavar="S",
        help="added to the trajectory's stamps to compare them (default: 0 s)")  # fmt: skip
    add("--gt", type=Path, metavar="TUM", help="ground truth for ATE and RPE")


def map_inputs(args: argparse.Namespace, name: str) -> MapInputs:
    """Read the files to compare with before anything is mapped, so that a bad one costs nothing.

    Raises:
        ValueError: One cannot be read, or something is said of one that is not there.
    """
    tolerance, offset = args.relations_tol, args.relations_offset
    if args.relations is None:
        for option, value in (("--relations-tol", tolerance), ("--relations-offset", offset)):
            if value is not None:
                raise ValueError(f"{option} is of the relations in --relations FILE: name it too")
    tolerance = RELATIONS_TOL_S if tolerance is None else tolerance
    return MapInputs(
        name=name,
        title="/".join(args.recording.resolve().parts[-2:]),
        relations=_read("--relations", args.relations, load_relations),
        relations_tolerance_ns=round(tolerance * 1e9),
        relations_offset_ns=round((0.0 if offset is None else offset) * 1e9),
        truth=_read("--gt", args.gt, load_tum),
    )


def _read(option: str, path: Path | None, load: Callable[[Path], T]) -> T | None:
    """Read the file of an option, if there is one."""
    if path is None:
        return None
    if path.is_dir():
        raise ValueError(f"{option} {path} is a folder: name a file")
    try:
        return load(path)
    except OSError as error:
        raise ValueError(f"{option} {path}: {error.strerror or error}") from error


def recording_name(path: Path) -> str:
    """Return the name of a recording without its endings."""
    name = path.resolve().name
    for ending in ENDINGS:
        name = name.removesuffix(ending)
    return name


def recording_options(args: argparse.Namespace, frames: FrameConfig) -> RecordingOptions:
    """Return what was said on the command line and in the file of parameters.

    Raises:
        ValueError: A pose that is none.
    """
    return RecordingOptions(
        scan_topic=args.scan_topic,
        odom_topic=args.odom_topic,
        sonar_topics=tuple(args.sonar_topic),
        sonar_poses=tuple(_sonar_pose(*words) for words in args.sonar_pose),
        laser_pose=None if args.laser_pose is None else _laser_pose(*args.laser_pose),
        use_odom=not args.no_odom,
        base_frame=args.base_frame if args.base_frame is not None else _named(frames.base, "base"),
        odom_frame=args.odom_frame if args.odom_frame is not None else _named(frames.odom, "odom"),
        range_limits_m=None if args.range_limits is None else tuple(args.range_limits),
        use_recorded_stamps=args.recorded_stamps,
        wheels=WheelOptions(
            ticks_per_turn=args.ticks_per_turn,
            wheel_radius_m=args.wheel_radius,
            half_axle_m=args.half_axle,
        ),
    )


def _laser_pose(x: float, y: float, yaw: float) -> SE2:
    return _pose("--laser-pose", x, y, yaw)


def _sonar_pose(frame: str, *words: str) -> tuple[str, SE2]:
    try:
        x, y, yaw = (float(word) for word in words)
    except ValueError:
        raise ValueError(
            f"--sonar-pose: X Y YAW must be numbers (m, m, rad), got {' '.join(words)}"
        ) from None
    return frame.removeprefix("/"), _pose("--sonar-pose", x, y, yaw)


def _pose(option: str, x: float, y: float, yaw: float) -> SE2:
    if not abs(yaw) <= 2.0 * math.pi:
        raise ValueError(f"{option}: YAW is in radians, from -2 pi to 2 pi, got {yaw:g}")
    return SE2(x, y, yaw)


def _named(frame: str, name: str) -> str | None:
    """Return a frame that the configuration names; None where it has only the default."""
    return None if frame == getattr(FrameConfig(), name) else frame
