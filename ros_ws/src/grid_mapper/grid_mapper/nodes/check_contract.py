"""Test messages, live or from a bag, against what their consumers publish as rules.

Without BAG it listens for a while. Judged are LaserScan, Range, Odometry,
PoseWithCovarianceStamped, OccupancyGrid and TF: frames, stamps, inf and NaN, beam count,
covariances and QoS as Nav2's layers, slam_toolbox, AMCL and robot_localization want them.
`--rules` prints all rules with their sources.
Exit code 0: all passed, 1: a rule is broken or nothing came, 2: bad input.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from floornav_common.arguments import positive
from floornav_common.progress import Progress, say
from floornav_common.reporting import (
    Section,
    Table,
    UserError,
    add_common_options,
    open_out_dir,
    summary,
    write_html,
)
from grid_mapper.contract.judge import JUDGED_TYPES, RULES, judge
from grid_mapper.contract.rule import FAILED, PASSED, Topic, Verdict
from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.events import RecordingError

DEFAULT_DURATION_S = 5.0
_HEADER = ["topic", "rule", "result", "what is wrong", "who wants it"]
_TF_TOPICS = ("/tf", "/tf_static")
_SPIN_S = 0.1


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    if args.rules:
        print(as_text(rules_table()))
        return 0
    topics = from_bag(args.bag, args.topics) if args.bag else live(args)
    name = Path(args.bag).stem if args.bag else "live"
    out = open_out_dir("check_contract", name, args.out)
    with summary(out, command="check_contract", seed=None, values={"topics": {}}) as values:
        verdicts = judge(topics)
        shown = [v for v in verdicts if not args.topics or v.topic in args.topics]
        values["topics"] = as_values(topics, shown)
        values["ok"] = is_kept(shown)
    tables = [Section("Verdicts", [table(shown)]), Section("Rules", [rules_table()])]
    write_html(out, f"check_contract: {name}", tables)
    say(as_text(table(shown)), is_quiet=args.quiet)
    for topic in sorted({v.topic for v in shown}):
        say(topic_line(topic, topics, shown), is_quiet=args.quiet)
    say(f"results: {out}", is_quiet=args.quiet)
    return 0 if is_kept(shown) else 1


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="check_contract", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    add = parser.add_argument
    add("bag", nargs="?", type=Path, metavar="BAG", help="rosbag2 folder or file; none: live")
    add("--topics", nargs="+", metavar="TOPIC", help="judge only these (full names)")
    add("--duration", type=positive, default=DEFAULT_DURATION_S, metavar="S",
        help="listen for S seconds (default: %(default)g)")  # fmt: skip
    add("--rules", action="store_true", help="print the rules and where they are written, and end")
    add_common_options(parser)
    return parser


def from_bag(path: Path, wanted: Sequence[str] | None) -> list[Topic]:
    """Return the topics of a bag that have rules, with all their messages.

    Raises:
        UserError: The bag cannot be read, or has no such topics.
    """
    if not path.exists():
        raise UserError(f"{path} does not exist")
    try:
        with Bag(path) as bag:
            unknown = [name for name in wanted or () if name not in bag.topics]
            if unknown:
                known = ", ".join(bag.topics)
                raise UserError(f"{path} has no {', '.join(unknown)}; it has {known}")
            judged = {n: t for n, t in bag.topics.items() if t.msgtype in JUDGED_TYPES}
            topics = {n: Topic(n, t.msgtype, list(t.qos)) for n, t in judged.items()}
            _check_wanted({n: t.msgtype for n, t in bag.topics.items()}, wanted)
            for message in bag.messages(list(topics)):
                topics[message.topic].messages.append(bag.deserialize(message))
                topics[message.topic].arrived_ns.append(message.recorded_ns)
    except (RecordingError, ValueError) as error:
        raise UserError(str(error)) from error
    return list(topics.values())


def live(args: argparse.Namespace) -> list[Topic]:
    """Return what is heard on the graph for a while.

    Raises:
        UserError: Nobody publishes what was named, or it has no rules.
    """
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    from grid_mapper.nodes.bag_recorder_node import BagRecorderNode

    if not args.duration > 0.0:
        raise UserError(f"--duration must be > 0, got {args.duration:g}")
    heard = Heard()
    rclpy.init(args=[])
    wanted = [*args.topics, *_TF_TOPICS] if args.topics else []
    node = BagRecorderNode(wanted, heard)  # type: ignore[arg-type]
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    started = time.monotonic()
    try:
        with Progress("listening", args.duration, is_quiet=args.quiet) as progress:
            while (elapsed := time.monotonic() - started) < args.duration:
                executor.spin_once(timeout_sec=_SPIN_S)
                progress.update(elapsed, f"{heard.num_messages} messages")
        missing = [name for name in node.missing if name not in _TF_TOPICS]
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    if missing:
        raise UserError(f"nobody publishes {', '.join(missing)}")
    _check_wanted({name: topic.msgtype for name, topic in heard.topics.items()}, args.topics)
    return [topic for topic in heard.topics.values() if topic.msgtype in JUDGED_TYPES]


class Heard:
    """Takes what a recorder would write, and keeps the messages of types that have rules."""

    def __init__(self) -> None:
        """Start with nothing."""
        self.topics: dict[str, Topic] = {}
        self.num_messages = 0

    def add_topic(self, name: str, msgtype: str, qos: Sequence[Any], *_: str) -> None:
        """Note a topic."""
        self.topics[name] = Topic(name, msgtype, list(qos))

    def write(self, name: str, arrived_ns: int, data: bytes) -> None:
        """Keep one message."""
        from rclpy.serialization import deserialize_message

        from grid_mapper.nodes.message_types import message_class

        topic = self.topics[name]
        if topic.msgtype in JUDGED_TYPES:
            topic.messages.append(deserialize_message(data, message_class(topic.msgtype)))
            topic.arrived_ns.append(arrived_ns)
            self.num_messages += 1


def _check_wanted(types: dict[str, str], wanted: Sequence[str] | None) -> None:
    """Refuse topics without rules, and a lack of any with."""
    for name in wanted or ():
        if types.get(name) not in JUDGED_TYPES:
            raise UserError(f"{name} is a {types.get(name)}, for which there are no rules")
    if not any(kind in JUDGED_TYPES for kind in types.values()):
        raise UserError("there is no topic of a type that has rules: " + ", ".join(JUDGED_TYPES))


def is_kept(verdicts: Sequence[Verdict]) -> bool:
    """Return whether something was judged and nothing failed."""
    results = {verdict.result for verdict in verdicts}
    return PASSED in results and FAILED not in results


def table(verdicts: Sequence[Verdict]) -> Table:
    """Return all verdicts as a table."""
    return Table(_HEADER, [[v.topic, v.rule.name, v.result, v.text, v.rule.who] for v in verdicts])


def rules_table() -> Table:
    """Return all rules as a table."""
    rows = [[r.name, r.wants, r.who, r.source] for r in RULES]
    return Table(["rule", "wants", "who wants it", "source"], rows)


def topic_line(name: str, topics: Sequence[Topic], verdicts: Sequence[Verdict]) -> str:
    """Return what came of a topic."""
    own = [v for v in verdicts if v.topic == name]
    num_failed = sum(v.result == FAILED for v in own)
    num_messages = next(len(t.messages) for t in topics if t.name == name)
    num_passed = sum(v.result == PASSED for v in own)
    word = FAILED if num_failed else PASSED if num_passed else "not judged"
    return f"{word:5} {name}: {num_passed} of {len(own)} rules kept by {num_messages} messages"


def as_values(topics: Sequence[Topic], verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return all verdicts for `summary.json`."""
    return {
        t.name: {
            "type": t.msgtype,
            "messages": len(t.messages),
            "rules": {
                v.rule.name: {"result": v.result, "text": v.text or None}
                for v in verdicts if v.topic == t.name
            },
        }
        for t in topics if any(v.topic == t.name for v in verdicts)
    }  # fmt: skip


def as_text(rows: Table) -> str:
    """Return a table for the terminal."""
    cells = [[str(cell) for cell in row] for row in [rows.header, *rows.rows]]
    widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in cells]
    return "\n".join(line.rstrip() for line in lines)
