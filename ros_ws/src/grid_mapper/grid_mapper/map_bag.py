"""Map a recording offline: `map_bag.py BAG_OR_LOG [options] --out DIR`.

In lockstep: every scan is mapped, none is dropped for time, so the same input gives the same map
and trajectory, byte for byte.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from floornav_common import reporting
from floornav_common.frames import FrameConfig
from floornav_common.progress import Progress, say
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.config_file import load_mapper_config
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_run import loop_figures, run_closing
from grid_mapper.map_results import SUMMARY_KEYS, MapInputs, write_results
from grid_mapper.map_run import MapRun, run_mapper
from grid_mapper.pose_graph import load_solver
from grid_mapper.recordings import (
    Recording,
    RecordingError,
    RecordingOptions,
    open_recording,
)
from grid_mapper.recordings.events import WheelOptions
from grid_mapper.recordings.listing import describe_recording
from grid_mapper.relations import load_relations
from grid_mapper.sonar_mount import infrared_warning
from grid_mapper.trajectory_metrics import load_tum

COMMAND = "map_bag"


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    config, frames = _config(args)
    try:
        options = _options(args, frames)
        if args.list:
            say("\n".join(describe_recording(args.recording, options)))
            return 0
        inputs = _inputs(args)
        if config.loop_closing:
            load_solver()
        recording = open_recording(args.recording, options)
    except (RecordingError, ValueError, OSError) as error:
        raise UserError(" ".join(str(error).split())) from error
    for line in recording.info:
        say(f"  {line}", is_quiet=args.quiet)
    out = reporting.open_out_dir(COMMAND, _name(args.recording), args.out)
    values: dict[str, Any] = dict.fromkeys(SUMMARY_KEYS)
    with reporting.summary(out, command=COMMAND, seed=args.seed, values=values) as summary:
        run, mapper = _run(args, recording, options, config, summary)
        inputs.format, inputs.info = recording.format, tuple(recording.info)
        text = write_results(out, inputs, recording, run, mapper, summary)
    say(text, is_quiet=args.quiet)
    say(f"results: {out}", is_quiet=args.quiet)
    if recording.counts.infrared:
        print(f"warning: {infrared_warning(recording.counts.infrared)}", file=sys.stderr)
    if summary["problem"] is not None:
        state = "; the results are marked partial" if summary["partial"] else ""
        print(f"error: {summary['problem']}{state}", file=sys.stderr)
    if run.is_interrupted:
        print("stopped; results so far are marked partial", file=sys.stderr)
    return 0 if summary["ok"] else 1


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    description = (__doc__ or "").replace("map_bag.py", "%(prog)s")
    parser = argparse.ArgumentParser(description=description)
    add = parser.add_argument
    add("recording", type=Path, metavar="BAG_OR_LOG", help="rosbag2, ROS 1 bag or text log")
    add("--config", type=Path, metavar="YAML", help="parameters of grid_mapper")
    reporting.add_common_options(parser)
    _add_input_options(parser)
    add("--max-scans", type=_positive_int, metavar="N", help="stop after N scans")
    add("--relations", type=Path, metavar="FILE", help="known relations: t1 t2 x y z r p yaw")
    add("--relations-tol", type=_not_negative, default=0.002, metavar="S",
        help="how far a relation's stamp may be from a pose (default: 0.002 s)")  # fmt: skip
    add("--relations-offset", type=float, default=0.0, metavar="S",
        help="added to the trajectory's stamps to compare them (default: 0 s)")  # fmt: skip
    add("--gt", type=Path, metavar="TUM", help="ground truth for ATE and RPE")
    return parser


def _add_input_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what of the recording is used")
    add = group.add_argument
    add("--list", action="store_true", help="show topics, types and rates, and map nothing")
    add("--scan-topic", metavar="TOPIC", help="LaserScan topic (default: the only one, or /scan)")
    add("--odom-topic", metavar="TOPIC", help="odometry from this topic instead of TF")
    add("--sonar-topic", metavar="TOPIC", action="append", default=[],
        help="Range topic of ultrasonic sensors; may be given again")  # fmt: skip
    add("--sonar-pose", nargs=4, metavar=("FRAME", "X", "Y", "YAW"), action="append", default=[],
        help="where the sonar of a frame sits on the robot (m, m, rad); one a frame")  # fmt: skip
    add("--laser-pose", type=float, nargs=3, metavar=("X", "Y", "YAW"),
        help="where the laser sits on the robot (m, m, rad)")  # fmt: skip
    add("--no-odom", action="store_true", help="map without odometry")
    add("--base-frame", metavar="FRAME",
        help="frame of the robot (default: base_link, or what a bag has instead)")  # fmt: skip
    add("--odom-frame", metavar="FRAME",
        help="frame of the odometry (default: odom, or what a bag has instead)")  # fmt: skip
    add("--range-limits", type=float, nargs=2, metavar=("MIN", "MAX"),
        help="shortest and longest range that is a measurement (m, m)")  # fmt: skip
    add("--recorded-stamps", action="store_true",
        help="take the times of recording instead of a bag's stamps")  # fmt: skip
    wheels = WheelOptions()
    add("--ticks-per-turn", type=float, default=wheels.ticks_per_turn, metavar="N",
        help="for logs of wheel ticks: ticks of a wheel turn (default: %(default)s)")  # fmt: skip
    add("--wheel-radius", type=float, default=wheels.wheel_radius_m, metavar="M",
        help="for logs of wheel ticks (default: %(default)s m)")  # fmt: skip
    add("--half-axle", type=float, default=wheels.half_axle_m, metavar="M",
        help="for logs of wheel ticks (default: %(default)s m)")  # fmt: skip


def _config(args: argparse.Namespace) -> tuple[GridMapperConfig, FrameConfig]:
    if args.config is None:
        return GridMapperConfig(), FrameConfig()
    try:
        return load_mapper_config(args.config)
    except ValueError as error:
        raise UserError(str(error)) from error


def _options(args: argparse.Namespace, frames: FrameConfig) -> RecordingOptions:
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


def _inputs(args: argparse.Namespace) -> MapInputs:
    """Read the files to compare with before anything is mapped, so that a bad one costs nothing."""
    return MapInputs(
        name=_name(args.recording),
        title="/".join(args.recording.resolve().parts[-2:]),
        relations=None if args.relations is None else load_relations(args.relations),
        relations_tolerance_ns=round(args.relations_tol * 1e9),
        relations_offset_ns=round(args.relations_offset * 1e9),
        truth=None if args.gt is None else load_tum(args.gt),
    )


def _run(
    args: argparse.Namespace, recording: Recording, options: RecordingOptions,
    config: GridMapperConfig, summary: dict[str, Any],
) -> tuple[MapRun, LayeredMapper]:  # fmt: skip
    """Map the recording; with loops closed that takes two passes."""
    total = recording.num_scans
    if args.max_scans is not None:
        total = min(total, args.max_scans) if total is not None else args.max_scans
    if not (config.loop_closing and recording.has_laser):
        mapper = LayeredMapper(config)
        with Progress("mapping", total, is_quiet=args.quiet) as progress:
            return run_mapper(recording, mapper, args.max_scans, _shown(progress, total)), mapper
    passes = 2 * total if total is not None else None
    with Progress("mapping", passes, is_quiet=args.quiet) as progress:
        closed = run_closing(
            recording, lambda: open_recording(args.recording, options), config, args.max_scans,
            (_shown(progress, passes), _shown(progress, passes, total or 0)),
        )  # fmt: skip
    summary.update(loop_figures(closed.closer))
    return closed.run, closed.mapper


def _shown(progress: Progress, total: int | None, before: int = 0) -> Callable[[MapRun], None]:
    """Return what shows the progress of a run, behind `before` scans of another."""

    def on_scan(run: MapRun) -> None:
        done = before + len(run.trajectory)
        note = f"{len(run.trajectory)} scans, {len(run.untrusted)} not trusted"
        progress.update(done, note, is_last=done == total)

    return on_scan


def _name(path: Path) -> str:
    """Return the name of a recording without its endings."""
    name = path.resolve().name
    for ending in (".gz", ".zstd", ".log", ".dat", ".db3", ".mcap", ".bag"):
        name = name.removesuffix(ending)
    return name


def _positive_int(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {value}")
    return value


def _not_negative(text: str) -> float:
    value = float(text)
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f"must be 0 or more, got {value}")
    return value


def run() -> None:
    """Entry point of the installed command."""
    sys.exit(reporting.run_command(main))


if __name__ == "__main__":
    run()
