"""Replay a bag over DDS: `replay.py BAG [--rate R] [--loop]`, with `/clock` in recorded time."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions

from floornav_common.arguments import not_negative, positive
from floornav_common.progress import Progress, say
from floornav_common.reporting import UserError
from grid_mapper.nodes.bag_player_node import CLOCK_TOPIC, BagPlayerNode
from grid_mapper.nodes.bag_qos import load_overrides
from grid_mapper.nodes.record_bag import stop_on_signal
from grid_mapper.nodes.unfit_subscribers import UnfitSubscribers
from grid_mapper.recordings.bag import Bag, Message
from grid_mapper.recordings.events import RecordingError
from grid_mapper.recordings.playback import (
    PlayWindow,
    latched_before,
    messages_within,
    play_window,
)
from grid_mapper.recordings.replay_pace import LONGEST_SLEEP_S, ReplayPace, Stopped

DEFAULT_CLOCK_HZ = 100.0
SETTLE_S = 0.5
MATCHED_S = 0.2
"""The other side finds the match a little later than we do."""


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    should_stop = stop_on_signal()
    try:
        overrides = {} if args.qos is None else load_overrides(args.qos)
        remap = dict(_remap_pair(text) for text in args.remap)
        if not args.bag.exists():
            raise RecordingError(f"{args.bag} does not exist")
        bag = Bag(args.bag)
    except (RecordingError, ValueError) as error:
        raise UserError(str(error)) from error
    with bag:
        names = _chosen(bag, args)
        try:
            window = play_window(bag, args.start, args.duration)
        except ValueError as error:
            raise UserError(str(error)) from error
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        topics = [bag.topics[name] for name in names]
        node = BagPlayerNode(topics, remap, overrides, args.clock > 0.0)
        try:
            return _play(node, bag, window, args, should_stop)
        finally:
            node.destroy_node()
            rclpy.try_shutdown()


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="replay", description=__doc__)
    add = parser.add_argument
    add("bag", type=Path, metavar="BAG", help="rosbag2 folder or storage file")
    add("--rate", type=positive, default=1.0, metavar="R", help="speed (default: 1)")
    add("--loop", action="store_true", help="start again at the end, until Ctrl-C")
    add("--start", type=not_negative, default=0.0, metavar="S", help="begin S seconds in")
    add("--duration", type=positive, metavar="S", help="play S seconds of the bag")
    add("--topics", nargs="+", metavar="TOPIC", help="play only these")
    add("--remap", nargs="+", default=[], metavar="A:=B", help="publish topic A as B")
    add("--qos", type=Path, metavar="FILE", help="YAML, topic: {reliability: ..., depth: ...}")
    add("--clock", type=not_negative, default=DEFAULT_CLOCK_HZ, metavar="HZ",
        help="rate of /clock in real time, 0 for none (default: %(default)g)")  # fmt: skip
    add("--wait", type=not_negative, default=3.0, metavar="S",
        help="wait at most S seconds for subscribers (default: %(default)g)")  # fmt: skip
    add("--quiet", action="store_true", help="print errors only")
    return parser


def _play(
    node: BagPlayerNode,
    bag: Bag,
    window: PlayWindow,
    args: argparse.Namespace,
    should_stop: Callable[[], bool],
) -> int:
    for name, msgtype in node.unknown_types.items():
        say(f"  passed over: {name} (no {msgtype} on this machine)", is_quiet=args.quiet)
    if not node.playable:
        raise UserError(f"{args.bag}: no topic that this machine knows the type of")
    code = 0
    unfit = node.watch_unfit(lambda line: print(f"warning: {line}", file=sys.stderr))
    try:
        for message in latched_before(bag, node.playable, window.start_ns):
            node.play(message)
        _wait_for_subscribers(node, args.wait, should_stop)
        unfit.look()
        _play_rounds(node, unfit, bag, window, args, should_stop)
        node.wait_for_delivery()
        unfit.look()
    except Stopped:
        code = 0 if args.loop else 1
        print("stopped", file=sys.stderr)
    for problem in bag.problems:
        print(f"error: {problem}", file=sys.stderr)
    return 1 if bag.problems else code


def _play_rounds(
    node: BagPlayerNode,
    unfit: UnfitSubscribers,
    bag: Bag,
    window: PlayWindow,
    args: argparse.Namespace,
    should_stop: Callable[[], bool],
) -> None:
    def tick(now_ns: int) -> None:
        node.tick(now_ns)
        unfit.look_now_and_then()

    length_s = (window.end_ns - window.start_ns) * 1e-9
    with Progress("replaying", length_s, is_quiet=args.quiet) as progress:
        while True:
            clocks = time.monotonic(), time.monotonic, time.sleep
            pace = ReplayPace(window, args.rate, args.clock, *clocks)
            node.tick(window.start_ns)
            num_played = 0
            for message in _in_time(bag, node.playable, pace, tick, should_stop):
                node.play(message)
                num_played += 1
                unfit.look_now_and_then()  # no tick comes between messages that are late
                done_s = (message.recorded_ns - window.start_ns) * 1e-9
                progress.update(done_s, f"{done_s:.1f} s, {num_played} messages")
            pace.wait_for(window.end_ns, tick, should_stop)
            node.tick(window.end_ns)
            progress.update(length_s, f"{length_s:.1f} s, {num_played} messages", is_last=True)
            if not args.loop:
                return


def _in_time(
    bag: Bag,
    playable: list[str],
    pace: ReplayPace,
    tick: Callable[[int], None],
    should_stop: Callable[[], bool],
) -> Iterator[Message]:
    """Yield each message when it is due."""
    for message in messages_within(bag, playable, pace.window):
        pace.wait_for(message.recorded_ns, tick, should_stop)
        yield message


def _wait_for_subscribers(
    node: BagPlayerNode, longest_s: float, should_stop: Callable[[], bool]
) -> None:
    """Wait until all topics are heard, or no more come to be heard for a moment, or too long."""
    started_s = time.monotonic()
    num_heard, changed_s = 0, started_s
    while not should_stop() and num_heard < len(node.playable):
        now_s = time.monotonic()
        if node.num_heard != num_heard:
            num_heard, changed_s = node.num_heard, now_s
        is_settled = num_heard > 0 and now_s - changed_s > SETTLE_S
        if is_settled or now_s - started_s >= longest_s:
            break
        time.sleep(LONGEST_SLEEP_S)
    if num_heard > 0:
        time.sleep(MATCHED_S)
    if should_stop():
        raise Stopped


def _chosen(bag: Bag, args: argparse.Namespace) -> list[str]:
    """Return the topics to play.

    Raises:
        UserError: If one is not in the bag, there is none, or it is a ROS 1 bag.
    """
    if bag.is_ros1:
        command = f"{sys.executable} -m rosbags.convert --src {shlex.quote(str(args.bag))}"
        target = shlex.quote(str(args.bag.with_suffix("")))
        raise UserError(f"{args.bag} is a ROS 1 bag, convert it: {command} --dst {target}")
    unknown = [name for name in args.topics or () if name not in bag.topics]
    if unknown:
        raise UserError(f"{args.bag} has no {', '.join(unknown)}; it has {', '.join(bag.topics)}")
    names = [n for n in args.topics or bag.topics if bag.topics[n].num_messages > 0]
    if args.clock > 0.0 and CLOCK_TOPIC in names:
        say(f"  passed over: {CLOCK_TOPIC} of the bag, for ours", is_quiet=args.quiet)
        names.remove(CLOCK_TOPIC)
    if not names:
        raise UserError(f"{args.bag} holds no messages to play")
    return names


def _remap_pair(text: str) -> tuple[str, str]:
    before, separator, after = text.partition(":=")
    if not (separator and before and after):
        raise ValueError(f"--remap wants A:=B, got {text!r}")
    return before, after
