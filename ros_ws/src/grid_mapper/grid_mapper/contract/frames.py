"""Rules for headers, for transforms, and for what connects frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grid_mapper.contract.poses import QUATERNION, quaternion_problem
from grid_mapper.contract.rule import FAILED, OPEN, PASSED, Rule, Topic, Verdict, of_problems

_NS = 1e-9
_DAY_NS = 86_400 * 10**9
_AHEAD_S, _BEHIND_S = 0.1, 10.0

FRAME = Rule(
    "frame_id", "given, without a leading /", "tf2, and all that look frames up",
    "tf2 src/buffer_core.cpp validateFrameId; REP 105",
)  # fmt: skip
STAMP = Rule(
    "stamps", "not 0, each later than the one before",
    "robot_localization, which leaves older ones out; tf2 message filters",
    "robot_localization src/ros_filter.cpp; tf2_ros message_filter.h",
)  # fmt: skip
AGE = Rule(
    "age", "on arrival at most 0.1 s ahead and 10 s old, what TF buffers hold",
    "Nav2's layers, slam_toolbox, AMCL: they look TF up at the stamp",
    "tf2 buffer_core.hpp BUFFER_CORE_DEFAULT_CACHE_TIME; tf2_ros message_filter.h",
)  # fmt: skip
CONNECTED = Rule(
    "in the tree", "TF connects the message's frame with base_link (or base_footprint)",
    "Nav2's layers, slam_toolbox, AMCL, robot_localization",
    "slam_toolbox src/laser_utils.cpp isInverted; nav2_amcl amcl_node.cpp; REP 105",
)  # fmt: skip
PARENT = Rule(
    "one parent", "a frame has one parent, and is not its own", "tf2", "REP 105; tf2 setTransform"
)
RULES = (FRAME, STAMP, AGE, CONNECTED, PARENT)
BASES = ("base_link", "base_footprint")
Tree = dict[str, set[str]]
"""The parents of each frame."""


def judge_headers(topic: Topic, is_latched: bool) -> list[Verdict]:
    """Return the verdicts on the headers of a topic; a latched one may be as old as it likes."""
    frames = [frame_problem(m.header.frame_id) for m in topic.messages]
    stamps = [stamp_ns(m.header.stamp) for m in topic.messages]
    verdicts = [
        of_problems(topic, FRAME, frames),
        of_problems(topic, STAMP, stamp_problems(stamps, by_frame(topic.messages))),
    ]
    if is_latched:
        return verdicts
    return [*verdicts, age_verdict(topic, stamps)]


def stamp_ns(stamp: Any) -> int:
    """Return a builtin_interfaces/Time in ns."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def by_frame(messages: Iterable[Any]) -> list[str]:
    """Return what tells the senders on one topic apart: sonars share one."""
    return [m.header.frame_id for m in messages]


def frame_problem(frame: str) -> str:
    """Return what is wrong with a frame id."""
    if not frame:
        return "frame_id is empty"
    return f"frame_id {frame} begins with /" if frame.startswith("/") else ""


def stamp_problems(stamps: list[int], senders: list[str]) -> list[str]:
    """Return for each stamp, ns, whether it is 0 or not later than the sender's one before."""
    last: dict[str, int] = {}
    problems = []
    for stamp, sender in zip(stamps, senders, strict=True):
        before = last.get(sender)
        if stamp == 0:
            problems.append("stamp 0")
        elif before is not None and stamp <= before:
            problems.append(f"stamp {stamp * _NS:.3f} s after {before * _NS:.3f} s")
        else:
            problems.append("")
        last[sender] = stamp
    return problems


def age_verdict(topic: Topic, stamps: list[int]) -> Verdict:
    """Return the verdict on how old messages are on arrival, if both clocks are one."""
    ages = [a - s for a, s in zip(topic.arrived_ns, stamps, strict=True)]
    if ages and min(abs(age) for age in ages) > _DAY_NS:
        return Verdict(topic.name, AGE, OPEN, "stamped by another clock than it arrived by")
    problems = [
        f"{abs(age) * _NS:.3f} s {'old' if age > 0 else 'ahead'}"
        if not -_AHEAD_S <= age * _NS <= _BEHIND_S else ""
        for age in ages
    ]  # fmt: skip
    return of_problems(topic, AGE, problems)


def tree_of(topics: Iterable[Topic]) -> Tree:
    """Return the parents of each frame, from all topics of transforms."""
    tree: Tree = {}
    for topic in topics:
        for message in topic.messages:
            for t in message.transforms:
                child, parent = (f.removeprefix("/") for f in (t.child_frame_id, t.header.frame_id))
                tree.setdefault(child, set()).add(parent)
    return tree


def judge_connection(topic: Topic, tree: Tree) -> Verdict:
    """Return whether each frame of a topic is connected with the robot."""
    if not tree:
        return Verdict(topic.name, CONNECTED, OPEN, "no transforms were heard")
    frames = sorted({m.header.frame_id.removeprefix("/") for m in topic.messages})
    alone = [f for f in frames if not robot_root(f, tree)]
    if not frames or not alone:
        return Verdict(topic.name, CONNECTED, PASSED if frames else OPEN)
    known = (
        "is in no transform" if alone[0] not in _all(tree) else "is not connected with the robot"
    )
    return Verdict(topic.name, CONNECTED, FAILED, f"{alone[0]} {known}")


def robot_root(frame: str, tree: Tree) -> bool:
    """Return whether a frame's tree holds a frame of the robot."""
    roots = _roots(frame, tree)
    bases = [f for f in _all(tree) if f.rpartition("/")[2] in BASES]
    return any(roots & _roots(base, tree) for base in bases)


def judge_transforms(topic: Topic, tree: Tree) -> list[Verdict]:
    """Return the verdicts on a topic of transforms."""
    sent = [t for message in topic.messages for t in message.transforms]
    frames = [
        frame_problem(t.header.frame_id) or frame_problem(t.child_frame_id) for t in sent
    ]  # fmt: skip
    return [
        of_problems(topic, FRAME, frames),
        of_problems(topic, QUATERNION, [quaternion_problem(t.transform.rotation) for t in sent]),
        of_problems(topic, PARENT, [parent_problem(t, tree) for t in sent]),
    ]


def parent_problem(stamped: Any, tree: Tree) -> str:
    """Return whether a frame is its own parent or has two."""
    child = stamped.child_frame_id.removeprefix("/")
    parents = sorted(tree.get(child, ()))
    if child in parents:
        return f"{child} is its own parent"
    return f"{child} has the parents {' and '.join(parents)}" if len(parents) > 1 else ""


def _all(tree: Tree) -> set[str]:
    return set(tree).union(*tree.values())


def _roots(frame: str, tree: Tree) -> set[str]:
    """Return the frames above a frame that have no parent; itself alone if it is in no tree."""
    above, open_frames = {frame}, [frame]
    while open_frames:
        for parent in tree.get(open_frames.pop(), ()):
            if parent not in above:
                above.add(parent)
                open_frames.append(parent)
    return {f for f in above if f not in tree and (f in _all(tree))}
