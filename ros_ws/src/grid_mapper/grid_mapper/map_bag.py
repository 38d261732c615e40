"""Map a recording offline: `map_bag.py BAG_OR_LOG [options] --out DIR`.

In lockstep: every scan is mapped, none is dropped for time, so the same input gives the same map
and trajectory, byte for byte.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from floornav_common import reporting
from floornav_common.arguments import count
from floornav_common.frames import FrameConfig
from floornav_common.progress import Progress, say
from floornav_common.reporting import UserError
from grid_mapper.config import GridMapperConfig
from grid_mapper.config_file import load_mapper_config
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_run import Sessions, loop_figures, run_closing
from grid_mapper.map_bag_options import (
    add_comparison_options,
    add_input_options,
    map_inputs,
    recording_name,
    recording_options,
)
from grid_mapper.map_results import SUMMARY_KEYS, write_results
from grid_mapper.map_run import MapRun, run_mapper
from grid_mapper.pose_graph import load_solver
from grid_mapper.recordings import (
    Recording,
    RecordingError,
    RecordingOptions,
    open_recording,
)
from grid_mapper.recordings.listing import describe_recording
from grid_mapper.session_files import load_session
from grid_mapper.session_run import take_up
from grid_mapper.sonar_mount import infrared_warning

COMMAND = "map_bag"


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    config, frames = _config(args)
    try:
        options = recording_options(args, frames)
        if args.list:
            say("\n".join(describe_recording(args.recording, options)))
            return 0
        inputs = map_inputs(args, recording_name(args.recording))
        if args.out is not None and Path(args.out).is_file():
            raise ValueError(f"--out {args.out} is a file: name a folder for the results")
        if config.loop_closing:
            load_solver()
        _check_sessions(args, config)
        recording = open_recording(args.recording, options)
        sessions = _sessions(args, config, recording, options)
    except (RecordingError, ValueError, OSError) as error:
        raise UserError(" ".join(str(error).split())) from error
    for line in recording.info:
        say(f"  {line}", is_quiet=args.quiet)
    out = reporting.open_out_dir(COMMAND, inputs.name, args.out)
    values: dict[str, Any] = dict.fromkeys(SUMMARY_KEYS)
    with reporting.summary(out, command=COMMAND, seed=args.seed, values=values) as summary:
        run, mapper = _run(args, recording, options, config, sessions, summary)
        inputs.format, inputs.info = recording.format, tuple(recording.info)
        text = write_results(out, inputs, recording, run, mapper, summary)
    say(f"{text}\nresults: {out}", is_quiet=args.quiet)
    _warn(recording, run, summary)
    return 0 if summary["ok"] else 1


def _warn(recording: Recording, run: MapRun, summary: dict[str, Any]) -> None:
    """Print what is wrong with a recording or a run."""
    if recording.counts.infrared:
        print(f"warning: {infrared_warning(recording.counts.infrared)}", file=sys.stderr)
    if summary["problem"] is not None:
        state = "; the results are marked partial" if summary["partial"] else ""
        print(f"error: {summary['problem']}{state}", file=sys.stderr)
    if run.is_interrupted:
        print("stopped; results so far are marked partial", file=sys.stderr)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    description = (__doc__ or "").replace("map_bag.py", "%(prog)s")
    parser = argparse.ArgumentParser(description=description)
    add = parser.add_argument
    add("recording", type=Path, metavar="BAG_OR_LOG", help="rosbag2, ROS 1 bag or text log")
    add("--config", type=Path, metavar="YAML", help="parameters of grid_mapper")
    reporting.add_common_options(parser)
    add_input_options(parser)
    add("--max-scans", type=count, metavar="N", help="stop after N scans")
    add("--session", type=Path, metavar="FILE", help="go on with a session that was saved")
    add("--save-session", type=Path, metavar="FILE", help="save the session to go on with it")
    add_comparison_options(parser)
    return parser


def _config(args: argparse.Namespace) -> tuple[GridMapperConfig, FrameConfig]:
    if args.config is None:
        return GridMapperConfig(), FrameConfig()
    try:
        return load_mapper_config(args.config)
    except ValueError as error:
        raise UserError(str(error)) from error


def _check_sessions(args: argparse.Namespace, config: GridMapperConfig) -> None:
    """Refuse sessions that cannot be, before anything is read.

    Raises:
        ValueError: None can be made, or not there.
    """
    if (args.session or args.save_session) and not config.loop_closing:
        raise ValueError("sessions are of runs that close loops; loop_closing is false")
    save: Path | None = args.save_session
    if save is None:
        return
    if not save.parent.is_dir():
        raise ValueError(f"--save-session: there is no folder {save.parent}")
    if save.is_dir() or not os.access(save.parent, os.W_OK):
        raise ValueError(f"--save-session: {save} cannot be written")


def _sessions(
    args: argparse.Namespace, config: GridMapperConfig, recording: Recording,
    options: RecordingOptions,
) -> Sessions:  # fmt: skip
    """Return the sessions asked for.

    Raises:
        ValueError: One cannot be taken up, or not with this recording.
    """
    if (args.session or args.save_session) and not recording.has_laser:
        raise ValueError("sessions are of recordings with a laser; this one has none")
    if args.session is None:
        return Sessions(None, args.save_session)
    before = load_session(args.session, config)
    return Sessions(take_up(before, open_recording(args.recording, options)), args.save_session)


def _run(
    args: argparse.Namespace, recording: Recording, options: RecordingOptions,
    config: GridMapperConfig, sessions: Sessions, summary: dict[str, Any],
) -> tuple[MapRun, LayeredMapper]:  # fmt: skip
    """Map the recording; with loops closed that takes two passes."""
    total = recording.num_scans
    if args.max_scans is not None:
        total = min(total, args.max_scans) if total is not None else args.max_scans
    if not (config.loop_closing and recording.has_laser):
        mapper = LayeredMapper(config)
        with Progress("mapping", total, is_quiet=args.quiet) as progress:
            run = run_mapper(recording, mapper, args.max_scans, _shown(progress, total))
        summary.update(beam_order=mapper.laser.sweeps.words(config.deskew) or None)
        return run, mapper
    first, second = _amounts(sessions, total)
    passes = None if first is None or second is None else first + second
    with Progress("mapping", passes, is_quiet=args.quiet) as progress:
        again = _shown(progress, passes, first or 0, "maps of ")
        closed = run_closing(
            recording, lambda: open_recording(args.recording, options), config, args.max_scans,
            (_shown(progress, passes), again), sessions,
        )  # fmt: skip
    summary.update(loop_figures(closed.closer))
    summary.update(beam_order=closed.sweeps.words(config.deskew) or None)
    return closed.run, closed.mapper


def _amounts(sessions: Sessions, total: int | None) -> tuple[int | None, int | None]:
    """Return how many scans poses are found for, and how many maps are made of then."""
    if sessions.before is None or total is None:
        return total, total
    held = sessions.before.session.num_scans
    new = total if sessions.before.taken is None else max(total - held, 0)
    return new, held + new


def _shown(
    progress: Progress, total: int | None, before: int = 0, what: str = ""
) -> Callable[[MapRun], None]:
    """Return what shows the progress of a run, behind `before` scans of another."""

    def on_scan(run: MapRun) -> None:
        done = before + len(run.trajectory)
        done = done if total is None else min(done, total)
        note = f"{what}{len(run.trajectory)} scans, {len(run.untrusted)} not trusted"
        progress.update(done, note, is_last=done == total)

    return on_scan


def run() -> None:
    """Entry point of the installed command."""
    sys.exit(reporting.run_command(main))


if __name__ == "__main__":
    run()
