"""Show what is said on topics, one line a message: `echo TOPIC ... [--ros-args ...]`.

    echo /floor_pose /diagnostics     until Ctrl-C
    echo /floor_pose --count 1        the next one
    echo --list                       which topics there are

Types are found in the graph. Of /diagnostics only what is new or has changed is shown.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.utilities import remove_ros_args

from floornav_common.arguments import natural
from floornav_common.message_lines import one_line
from floornav_common.ros.main import run_nodes

_LEVELS = ("OK", "WARN", "ERROR", "STALE")
_LOOK_S = 0.2
_LOOKS_OF_LIST, _LOOKS_BEFORE_WORD = 15, 25
_DEPTH = 50


class EchoNode(Node):
    """Subscribes to topics once somebody publishes them, and prints."""

    def __init__(self, topics: Sequence[str], count: int) -> None:
        """Begin to look for them; with none, list what there is."""
        super().__init__("echo", enable_rosout=False, start_parameter_services=False)
        self._waiting = {self.resolve_topic_name(topic): topic for topic in topics}
        self._is_list, self._left, self._num_looks = not topics, count, 0
        self._said: dict[str, tuple[bytes, str]] = {}
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(_LOOK_S, self._look, clock=steady)

    def _look(self) -> None:
        self._num_looks += 1
        types = dict(self.get_topic_names_and_types())
        if self._is_list:
            if self._num_looks == _LOOKS_OF_LIST:
                _say("\n".join(f"{n}  {', '.join(t)}" for n, t in sorted(types.items())))
                rclpy.try_shutdown()
            return
        for topic in [t for t in self._waiting if self.count_publishers(t)]:
            del self._waiting[topic]
            self._subscribe(topic)
        if self._waiting and self._num_looks == _LOOKS_BEFORE_WORD:
            names = ", ".join(self._waiting)
            print(f"nobody publishes {names} yet: waiting (--list shows topics)", file=sys.stderr)

    def _subscribe(self, topic: str) -> None:
        offers = self.get_publishers_info_by_topic(topic)
        kind = offers[0].topic_type
        try:
            message = message_class(kind)
        except (ImportError, AttributeError):
            print(f"{topic}: messages of type {kind} are not installed", file=sys.stderr)
            return
        self.create_subscription(
            message, topic, lambda msg: self._show(topic, msg), _matching(offers)
        )

    def _show(self, topic: str, msg: Any) -> None:
        is_diagnostic = type(msg).__name__ == "DiagnosticArray"
        lines = self._changes(msg) if is_diagnostic else [one_line(msg)]
        for line in lines:
            _say(f"{topic} {line}")
        if lines and self._left:
            self._left -= 1
            if not self._left:
                rclpy.try_shutdown()

    def _changes(self, msg: Any) -> list[str]:
        lines = []
        for status in msg.status:
            key = (status.level, status.message)
            if self._said.get(status.name) != key:
                self._said[status.name] = key
                lines.append(f"{_LEVELS[status.level[0] % 4]:5} {status.name}: {status.message}")
        return lines


def _say(line: str) -> None:
    """Print a line; where nobody reads any more, as behind `head`, end quietly."""
    try:
        print(line, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        rclpy.try_shutdown()


def message_class(kind: str) -> Any:
    """Return the class of a type such as `std_msgs/msg/Bool`.

    Raises:
        ImportError: If the package is not there.
        AttributeError: If it has no such message.
    """
    package, group, name = kind.split("/")
    return getattr(import_module(f"{package}.{group}"), name)


def _matching(offers: Sequence[Any]) -> QoSProfile:
    """Return the strictest profile that matches all publishers."""
    given = [offer.qos_profile for offer in offers]
    is_reliable = all(q.reliability == ReliabilityPolicy.RELIABLE for q in given)
    is_latched = all(q.durability == DurabilityPolicy.TRANSIENT_LOCAL for q in given)
    return QoSProfile(
        depth=_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


def main(args: list[str] | None = None) -> int:
    """Parse the command line and show until it is told to stop; returns the exit code."""
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="echo", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("topics", nargs="*", metavar="TOPIC")
    parser.add_argument("--count", type=natural, default=0, help="end after that many messages")
    parser.add_argument("--list", action="store_true", help="show topics and types, and end")
    given = parser.parse_args(remove_ros_args(["echo", *words])[1:])
    if given.count < 0 or bool(given.topics) == given.list:
        parser.error("TOPIC ... or --list is needed, and a --count that is not negative")
    at = words.index("--ros-args") if "--ros-args" in words else len(words)
    return run_nodes([lambda: EchoNode(given.topics, given.count)], ["echo", *words[at:]])


if __name__ == "__main__":
    sys.exit(main())
