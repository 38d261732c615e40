"""Which topics and frames of a bag are used: by option, else by type, else one clear error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_checks import check_clocks, check_scans, laser_info
from grid_mapper.recordings.bag_frames import (
    base_frame,
    fixed_links,
    never_moves,
    odom_child,
    odom_frame,
    plain,
)
from grid_mapper.recordings.bag_messages import StampedTransform
from grid_mapper.recordings.bag_survey import FrameTree, Survey, survey, tf_topics
from grid_mapper.recordings.bag_types import (
    ECHO_TYPE,
    ODOM_TYPE,
    RANGE_TYPE,
    SCAN_TYPE,
    TEXT_TYPE,
)
from grid_mapper.recordings.events import RecordingError, RecordingOptions
from grid_mapper.recordings.robot_description import fixed_transforms

SCAN_NAME = "scan"
ODOM_TOPIC = "/odom"
DESCRIPTION_NAME = "robot_description"


@dataclass(frozen=True)
class Choice:
    """What of a bag is used.

    Attributes:
        scan_topic: LaserScan topic.
        sonar_topics: Range topics.
        odom_topic: Odometry topic, where no TF has the odometry; else None.
        odom_child: Frame whose pose that topic gives; the robot's if TF does not know it.
        tf_topics: All topics that carry transforms.
        base_frame: Frame of the robot.
        odom_frame: Frame of the odometry in TF; None where TF is not used for it.
        tree: Which frames hang together.
        fixed: Transforms that hold from the start, by parent and child.
        info: What the user shall know.
    """

    scan_topic: str
    sonar_topics: tuple[str, ...]
    odom_topic: str | None
    odom_child: str
    tf_topics: tuple[str, ...]
    base_frame: str
    odom_frame: str | None
    tree: FrameTree
    fixed: dict[tuple[str, str], StampedTransform]
    info: tuple[str, ...]


def choose(bag: Bag, options: RecordingOptions) -> Choice:
    """Decide what of a bag is used.

    Raises:
        RecordingError: With the option that would settle what the bag leaves open.
    """
    options = _with_full_names(bag, options)
    scan_topic, scan_info = choose_scan_topic(bag, options)
    odom_topic, others = _odom_topic(bag, options) if options.use_odom else (None, "")
    found = survey(bag, scan_topic, [t for t in (odom_topic, *options.sonar_topics) if t])
    scan_notes = check_scans(bag.path, scan_topic, found, options)
    scan_frame = plain(found.first[scan_topic].header.frame_id)
    odom = found.first.get(odom_topic) if odom_topic else None
    described = _add_description(bag, found.tree, scan_frame, odom, options)
    base = base_frame(found.tree, scan_frame, odom, options)
    frame = _tf_odometry(found, base.name, odom, options)
    laser, odom_info = _all_or_errors(
        lambda: laser_info(bag.path, found, scan_topic, base.name, described, options),
        lambda: _odom_info(bag, found.tree, odom, odom_topic, frame, base.name, options),
    )
    if frame is not None:
        odom_topic = None
    child = (
        odom_child(odom) if odom_topic and found.tree.connects(odom_child(odom), base.name) else ""
    )
    notes = check_clocks(bag.path, found, scan_topic, odom_topic, frame, base.name, options)
    base_info = [f"robot frame: {base.name}, {base.why}"] if base.why else []
    sonar_info = [_sonar_info(bag, found, base.name, name) for name in options.sonar_topics]
    info = (scan_info, *scan_notes, *base_info, laser, odom_info + others, *notes, *sonar_info)
    return Choice(
        scan_topic, options.sonar_topics, odom_topic, child or base.name, tf_topics(bag),
        base.name, frame, found.tree, fixed_links(found.tree, base.name), info,
    )  # fmt: skip


def _with_full_names(bag: Bag, options: RecordingOptions) -> RecordingOptions:
    """Return the options with topics named as in the bag, which has a '/' before them."""

    def full(name: str) -> str:
        return f"/{name}" if name not in bag.topics and f"/{name}" in bag.topics else name

    return replace(
        options,
        scan_topic=None if options.scan_topic is None else full(options.scan_topic),
        odom_topic=None if options.odom_topic is None else full(options.odom_topic),
        sonar_topics=tuple(map(full, options.sonar_topics)),
    )


def _all_or_errors(*infos: Callable[[], str]) -> list[str]:
    """Return what each says.

    Raises:
        RecordingError: With the errors of all, so that one more try is enough.
    """
    texts, errors = [], []
    for info in infos:
        try:
            texts.append(info())
        except RecordingError as error:
            errors.append(str(error))
    if errors:
        raise RecordingError("; and ".join(errors))
    return texts


def choose_scan_topic(bag: Bag, options: RecordingOptions) -> tuple[str, str]:
    """Return the LaserScan topic and the line that says why.

    Raises:
        RecordingError: If there is none, or several of which none is called `scan`.
    """
    if options.scan_topic is not None:
        _require(bag, options.scan_topic, SCAN_TYPE, "--scan-topic")
        return options.scan_topic, f"scans: {options.scan_topic}, as asked"
    names, echoes = _names(bag, SCAN_TYPE), _names(bag, ECHO_TYPE)
    passed = f"; MultiEchoLaserScan is passed over: {', '.join(echoes)}" if echoes else ""
    if not names:
        listed = ", ".join(f"{t.name} ({t.msgtype})" for t in bag.topics.values()) or "none"
        raise RecordingError(f"{bag.path} has no LaserScan messages{passed}; its topics: {listed}")
    if len(names) == 1:
        return names[0], f"scans: {names[0]}, the only LaserScan topic{passed}"
    if f"/{SCAN_NAME}" in names:
        others = ", ".join(n for n in names if n != f"/{SCAN_NAME}")
        return (
            f"/{SCAN_NAME}",
            f"scans: /{SCAN_NAME} (not {others}: --scan-topic to change){passed}",
        )
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


def _odom_topic(bag: Bag, options: RecordingOptions) -> tuple[str | None, str]:
    """Return the Odometry topic, None if there is not one that stands out; and which it is not."""
    if options.odom_topic is not None:
        _require(bag, options.odom_topic, ODOM_TYPE, "--odom-topic")
        return options.odom_topic, ""
    names = _names(bag, ODOM_TYPE)
    if len(names) == 1:
        return names[0], ""
    if ODOM_TOPIC in names:
        others = ", ".join(n for n in names if n != ODOM_TOPIC)
        return ODOM_TOPIC, f" (not {others}: --odom-topic to change)"
    return None, ""


def _add_description(
    bag: Bag, tree: FrameTree, scan_frame: str, odom: Any | None, options: RecordingOptions
) -> bool:
    """Add the fixed joints of a recorded robot description where TF does not reach the laser."""
    base = base_frame(tree, scan_frame, odom, options).name
    if tree.connects(base, scan_frame) or options.laser_pose is not None:
        return False
    topics = [n for n in _names(bag, TEXT_TYPE) if n.endswith(DESCRIPTION_NAME)]
    for message in bag.messages(topics) if topics else ():
        try:
            transforms = fixed_transforms(bag.deserialize(message).data)
        except ValueError:
            continue
        for transform in transforms:
            if not tree.connects(plain(transform[0]), plain(transform[1])):
                tree.add(transform, message.recorded_ns, is_static=True)
        return True
    return False


def _sonar_info(bag: Bag, found: Survey, base: str, name: str) -> str:
    _require(bag, name, RANGE_TYPE, "--sonar-topic")
    first = found.first.get(name)
    if first is None:
        raise RecordingError(
            f"{bag.path}: no message on {name} can be read: leave out --sonar-topic {name}"
        )
    frame = plain(first.header.frame_id)
    if found.tree.connects(base, frame):
        return f"sonar: {name}, TF {base} -> {frame} and others of that topic"
    raise RecordingError(
        f"{bag.path} has no transform from {base} to {frame!r}: leave out --sonar-topic {name}"
    )


def _tf_odometry(
    found: Survey, base: str, odom: Any | None, options: RecordingOptions
) -> str | None:
    """Return the frame by which TF gives the odometry; None if it does not, or shall not."""
    if not options.use_odom or options.odom_topic is not None:
        return None
    frame = odom_frame(found.tree, base, odom, options)
    is_stand_in = frame is not None and never_moves(found.tree, frame, base)
    return None if is_stand_in and options.odom_frame is None else frame


def _odom_info(
    bag: Bag,
    tree: FrameTree,
    odom: Any | None,
    odom_topic: str | None,
    odom_frame: str | None,
    base: str,
    options: RecordingOptions,
) -> str:
    if not options.use_odom:
        return "odometry: not used, as asked"
    if odom_frame is not None:
        return f"odometry: TF {odom_frame} -> {base}"
    if odom_topic is not None:
        child = odom_child(odom)
        unsaid = "" if tree.connects(child, base) else (
            f"; its child frame {child or 'is not named and'} is taken as {base}: no transform"
            " joins them"
        )  # fmt: skip
        return f"odometry: topic {odom_topic}, interpolated{unsaid}"
    names = _names(bag, ODOM_TYPE)
    above = [frame for frame in tree.above(base)[1:] if frame != options.odom_frame]
    cures = [f"choose with --odom-topic {' or '.join(names)}"] if names else []
    if above and not names:
        cures.append(f"--odom-frame {above[-1]} takes what moves {base} there as odometry")
    cures.append("map without: --no-odom")
    raise RecordingError(
        f"{bag.path} has no moving transform from {options.odom_frame or 'odom'} to {base}"
        f" and no single Odometry topic: {', or '.join(cures)}"
    )
