"""Record topics to a bag: `record.py TOPIC... --out BAG`; Ctrl-C ends it and completes the bag."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from floornav_common.arguments import positive
from floornav_common.progress import Progress, say
from floornav_common.reporting import UserError
from grid_mapper.nodes.bag_recorder_node import BagRecorderNode
from grid_mapper.recordings.bag_writer import STORAGES, WRITE_ERRORS, BagWriter

SPIN_S = 0.1


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    if not args.topics and not args.all:
        raise UserError("name the topics to record, or add --all")
    path = free_path(args.out)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        writer = BagWriter(path, args.storage)
    except OSError as error:
        raise UserError(f"cannot write {path}: {error.strerror or error}") from error
    failure, counts = _recorded(args, writer)
    if writer.num_messages == 0:
        writer.abort()
        print("error: no message came, so no bag was written", file=sys.stderr)
        return 1
    if failure is None:
        failure = _closed(writer)
    else:
        writer.keep()
    if failure is not None:
        print(f"error: {path} is cut off, for it could not be written: {failure}", file=sys.stderr)
        return 1
    lines = [f"  {count:6d}  {name}" for name, count in counts.items()]
    say("\n".join([*lines, f"{writer.num_messages} messages in {path}"]), is_quiet=args.quiet)
    return 0


def _closed(writer: BagWriter) -> Exception | None:
    """Complete the bag; return the error if the disk refuses it."""
    try:
        writer.close()
    except WRITE_ERRORS as error:
        return error
    return None


def _recorded(
    args: argparse.Namespace, writer: BagWriter
) -> tuple[Exception | None, dict[str, int]]:
    """Record; return what ended it early, and the messages by topic. Ends ROS."""
    try:
        node = BagRecorderNode([] if args.all else args.topics, writer)
        failure = _record(node, writer, args.duration, args.quiet)
        for name in node.missing:
            say(f"nobody published {name}", is_quiet=args.quiet)
        counts = dict(sorted(node.counts.items()))
        node.destroy_node()
    except BaseException:
        writer.abort()
        raise
    finally:
        rclpy.try_shutdown()
    return failure, counts


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="record", description=__doc__)
    add = parser.add_argument
    add("topics", nargs="*", metavar="TOPIC", help="topics to record")
    add("--all", action="store_true", help="record every topic that someone publishes")
    add("--out", type=Path, default=Path("out") / "record-bag", metavar="BAG",
        help="folder of the new bag (default: %(default)s; -2, -3 ... if it exists)")  # fmt: skip
    add("--duration", type=positive, metavar="S", help="stop after S seconds")
    add("--storage", choices=tuple(STORAGES), default="mcap", help="default: %(default)s")
    add("--quiet", action="store_true", help="print errors only")
    return parser


def free_path(path: Path) -> Path:
    """Return the path, or with -2, -3 ... behind it if it exists; that is said."""
    free, number = path, 1
    while free.exists():
        number += 1
        free = path.with_name(f"{path.name}-{number}")
    if number > 1:
        print(f"{path} exists; the bag goes to {free}", file=sys.stderr)
    return free


def stop_on_signal() -> Callable[[], bool]:
    """Catch Ctrl-C and SIGTERM from now on; return what tells whether one came."""
    came: list[int] = []

    def on_signal(signum: int, frame: FrameType | None) -> None:
        came.append(signum)

    for signum in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signum, on_signal)
    return lambda: bool(came)


def _record(
    node: BagRecorderNode, writer: BagWriter, duration_s: float | None, is_quiet: bool
) -> Exception | None:
    """Record until told to stop; return the error if the disk refuses to take more."""
    should_stop = stop_on_signal()
    executor = SingleThreadedExecutor()  # EventsExecutor hands no reception time to callbacks
    executor.add_node(node)
    started = time.monotonic()
    with Progress("recording", duration_s, is_quiet=is_quiet) as progress:
        while not should_stop():
            elapsed_s = time.monotonic() - started
            if duration_s is not None and elapsed_s >= duration_s:
                break
            try:
                executor.spin_once(timeout_sec=SPIN_S)
            except WRITE_ERRORS as error:
                return error
            progress.update(elapsed_s, f"{writer.num_messages} messages")
    executor.remove_node(node)
    return None
