"""Which topics and frames of a bag are used: by option, else by type, else one clear error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from floornav_common.transform_buffer import clean_frame
from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_messages import StampedTransform, transforms_from
from grid_mapper.recordings.bag_types import ODOM_TYPE, RANGE_TYPE, SCAN_TYPE, TF_TYPE
from grid_mapper.recordings.events import RecordingError, RecordingOptions

SCAN_NAME = "scan"
ODOM_NAME = "odom"


@dataclass
class FrameTree:
    """Which frames hang together at any time of the bag.

    Attributes:
        groups: For each frame all that it hangs together with.
        statics: First static transform of each child frame.
    """

    groups: dict[str, set[str]] = field(default_factory=dict)
    statics: dict[str, StampedTransform] = field(default_factory=dict)

    def join(self, parent: str, child: str) -> None:
        """Note that a transform between two frames was recorded."""
        group = self.groups.get(parent, {parent}) | self.groups.get(child, {child})
        for frame in group:
            self.groups[frame] = group

    def connects(self, a: str, b: str) -> bool:
        """Tell whether a chain of recorded transforms joins two frames."""
        return b in self.groups.get(a, ()) or (a == b and a in self.groups)


@dataclass(frozen=True)
class Choice:
    """What of a bag is used.

    Attributes:
        scan_topic: LaserScan topic.
        sonar_topics: Range topics.
        odom_topic: Odometry topic, where no TF has the odometry; else None.
        tf_topics: All topics of type TFMessage.
        base_frame: Frame of the robot.
        odom_frame: Frame of the odometry in TF; None where TF is not used for it.
        tree: Which frames hang together; its static transforms hold from the start.
        info: What the user shall know.
    """

    scan_topic: str
    sonar_topics: tuple[str, ...]
    odom_topic: str | None
    tf_topics: tuple[str, ...]
    base_frame: str
    odom_frame: str | None
    tree: FrameTree
    info: tuple[str, ...]


def is_static_topic(name: str) -> bool:
    """Tell whether transforms of a topic hold at any time."""
    return name.endswith("tf_static")


def choose(bag: Bag, options: RecordingOptions) -> Choice:
    """Decide what of a bag is used.

    Raises:
        RecordingError: With the option that would settle what the bag leaves open.
    """
    scan_topic, scan_info = choose_scan_topic(bag, options)
    tf_topics = tuple(t.name for t in bag.topics.values() if t.msgtype == TF_TYPE)
    tree = _read_tree(bag, tf_topics)
    first = _first_message(bag, scan_topic)
    if first is None:
        raise RecordingError(f"{bag.path}: no message on {scan_topic} can be read")
    scan_frame = first.header.frame_id.removeprefix("/")
    odom_topic = _odom_topic(bag, options) if options.use_odom else None
    odom = _first_message(bag, odom_topic) if odom_topic else None
    base = _base_frame(tree, scan_frame, odom, options)
    laser_info = _laser_info(bag, tree, base, scan_frame, options)
    odom_frame = _odom_frame(tree, base, odom, options)
    odom_info = _odom_info(bag, odom_topic, odom_frame, base, options)
    if odom_frame is not None:
        odom_topic = None
    sonar_info = [_sonar_info(bag, tree, base, name) for name in options.sonar_topics]
    info = (scan_info, laser_info, odom_info, *sonar_info)
    return Choice(
        scan_topic, options.sonar_topics, odom_topic, tf_topics, base, odom_frame,
        tree, info,
    )  # fmt: skip


def choose_scan_topic(bag: Bag, options: RecordingOptions) -> tuple[str, str]:
    """Return the LaserScan topic and the line that says why.

    Raises:
        RecordingError: If there is none, or several of which none is called `scan`.
    """
    if options.scan_topic is not None:
        _require(bag, options.scan_topic, SCAN_TYPE, "--scan-topic")
        return options.scan_topic, f"scans: {options.scan_topic}, as asked"
    names = _names(bag, SCAN_TYPE)
    if not names:
        listed = ", ".join(f"{t.name} ({t.msgtype})" for t in bag.topics.values()) or "none"
        raise RecordingError(f"{bag.path} has no LaserScan messages; its topics: {listed}")
    if len(names) == 1:
        return names[0], f"scans: {names[0]}, the only LaserScan topic"
    if f"/{SCAN_NAME}" in names:
        others = ", ".join(n for n in names if n != f"/{SCAN_NAME}")
        return f"/{SCAN_NAME}", f"scans: /{SCAN_NAME} (not {others}: --scan-topic to change)"
    raise RecordingError(
        f"{bag.path} has several LaserScan topics: choose with --scan-topic {' or '.join(names)}"
    )


def _names(bag: Bag, msgtype: str) -> list[str]:
    return [t.name for t in bag.topics.values() if t.msgtype == msgtype and t.num_messages > 0]


def _require(bag: Bag, name: str, msgtype: str, option: str) -> None:
    topic = bag.topics.get(name)
    if topic is not None and topic.msgtype == msgtype and topic.num_messages > 0:
        return
    known = ", ".join(_names(bag, msgtype)) or "none"
    state = "has no topic" if topic is None else f"has no {msgtype} message on topic"
    raise RecordingError(f"{bag.path} {state} {name} ({option}); topics of that type: {known}")


def _odom_topic(bag: Bag, options: RecordingOptions) -> str | None:
    if options.odom_topic is not None:
        _require(bag, options.odom_topic, ODOM_TYPE, "--odom-topic")
        return options.odom_topic
    names = _names(bag, ODOM_TYPE)
    if f"/{ODOM_NAME}" in names:
        return f"/{ODOM_NAME}"
    return names[0] if len(names) == 1 else None


def _read_tree(bag: Bag, tf_topics: tuple[str, ...]) -> FrameTree:
    tree = FrameTree()
    seen: set[tuple[str, str]] = set()
    for message in bag.messages(tf_topics) if tf_topics else ():
        try:
            transforms = list(transforms_from(bag.deserialize(message)))
        except ValueError:
            continue
        for transform in transforms:
            pair = (transform[0], transform[1])
            if pair not in seen and all(name.strip("/") for name in pair):
                seen.add(pair)
                tree.join(clean_frame(pair[0]), clean_frame(pair[1]))
                if is_static_topic(message.topic):
                    tree.statics.setdefault(pair[1], transform)
    return tree


def _first_message(bag: Bag, topic: str) -> Any | None:
    for message in bag.messages((topic,)):
        try:
            return bag.deserialize(message)
        except ValueError:
            continue
    return None


def _base_frame(
    tree: FrameTree, scan_frame: str, odom: Any | None, options: RecordingOptions
) -> str:
    child = "" if odom is None else odom.child_frame_id.removeprefix("/")
    if child and not tree.connects(options.base_frame, scan_frame):
        return str(child)
    return options.base_frame


def _laser_info(
    bag: Bag, tree: FrameTree, base: str, scan_frame: str, options: RecordingOptions
) -> str:
    if options.laser_pose is not None:
        return "laser pose: as given on the command line"
    if tree.connects(base, scan_frame):
        return f"laser pose: TF {base} -> {scan_frame}"
    raise RecordingError(
        f"{bag.path} has no transform from {base} to {scan_frame}:"
        " say where the laser sits on the robot with --laser-pose X Y YAW (m, m, rad)"
    )


def _sonar_info(bag: Bag, tree: FrameTree, base: str, name: str) -> str:
    _require(bag, name, RANGE_TYPE, "--sonar-topic")
    first = _first_message(bag, name)
    frame = "" if first is None else first.header.frame_id.removeprefix("/")
    if tree.connects(base, frame):
        return f"sonar: {name}, TF {base} -> {frame} and others of that topic"
    raise RecordingError(
        f"{bag.path} has no transform from {base} to {frame}: leave out --sonar-topic {name}"
    )


def _odom_frame(
    tree: FrameTree, base: str, odom: Any | None, options: RecordingOptions
) -> str | None:
    if not options.use_odom or options.odom_topic is not None:
        return None
    header = "" if odom is None else odom.header.frame_id.removeprefix("/")
    candidates = [options.odom_frame, header]
    return next((f for f in candidates if f and tree.connects(f, base)), None)


def _odom_info(
    bag: Bag, odom_topic: str | None, odom_frame: str | None, base: str, options: RecordingOptions
) -> str:
    if not options.use_odom:
        return "odometry: not used, as asked"
    if odom_frame is not None:
        return f"odometry: TF {odom_frame} -> {base}"
    if odom_topic is not None:
        return f"odometry: topic {odom_topic}, interpolated"
    names = _names(bag, ODOM_TYPE)
    cure = f"choose with --odom-topic {' or '.join(names)}" if names else "map without: --no-odom"
    raise RecordingError(
        f"{bag.path} has no transform from {options.odom_frame} to {base}"
        f" and no single Odometry topic: {cure}"
    )
