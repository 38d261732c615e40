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
    odom_child,
    plain,
)
from grid_mapper.recordings.bag_messages import StampedTransform
from grid_mapper.recordings.bag_sonars import (
    has_sonars_alone,
    robot_frame,
    sonar_hint,
    sonar_info,
    unused_sonars,
)
from grid_mapper.recordings.bag_survey import FrameTree, Survey, survey, tf_topics
from grid_mapper.recordings.bag_topics import (
    choose_odom_topic,
    names_of,
    odom_info_of,
    require,
    tf_odometry,
)
from grid_mapper.recordings.bag_types import (
    ECHO_TYPE,
    RANGE_TYPE,
    SCAN_TYPE,
    TEXT_TYPE,
)
from grid_mapper.recordings.events import RecordingError, RecordingOptions
from grid_mapper.recordings.robot_description import fixed_transforms

SCAN_NAME = "scan"
DESCRIPTION_NAME = "robot_description"


@dataclass(frozen=True)
class Choice:
    """What of a bag is used.

    Attributes:
        scan_topic: LaserScan topic; "" where only sonars are mapped.
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
    for name in options.sonar_topics:
        require(bag, name, RANGE_TYPE, "--sonar-topic")
    if has_sonars_alone(bag, options):
        return _choose_sonars(bag, options)
    scan_topic, scan_info = choose_scan_topic(bag, options)
    odom_topic, others = choose_odom_topic(bag, options) if options.use_odom else (None, "")
    found = survey(bag, scan_topic, [t for t in (odom_topic, *options.sonar_topics) if t])
    scan_notes = check_scans(bag.path, scan_topic, found, options)
    scan_frame = plain(found.first[scan_topic].header.frame_id)
    odom = found.first.get(odom_topic) if odom_topic else None
    described = _add_description(bag, found.tree, scan_frame, odom, options)
    base = base_frame(found.tree, scan_frame, odom, options)
    frame = tf_odometry(found, base.name, odom, options)
    laser, odom_info = _all_or_errors(
        lambda: laser_info(bag.path, found, scan_topic, base.name, described, options),
        lambda: odom_info_of(bag, found.tree, odom, odom_topic, frame, base.name, options),
    )
    if frame is not None:
        odom_topic = None
    child = odom_child(odom) if odom_topic else ""
    child = child if child and found.tree.connects(child, base.name) else ""
    notes = check_clocks(bag.path, found, scan_topic, odom_topic, frame, base.name, options)
    base_info = [f"robot frame: {base.name}, {base.why}"] if base.why else []
    sonars = _sonar_lines(bag, found, base.name, options)
    info = (scan_info, *scan_notes, *base_info, laser, odom_info + others, *notes, *sonars)
    return Choice(
        scan_topic, options.sonar_topics, odom_topic, child or base.name, tf_topics(bag),
        base.name, frame, found.tree, fixed_links(found.tree, base.name), info,
    )  # fmt: skip


def _sonar_lines(bag: Bag, found: Survey, base: str, options: RecordingOptions) -> list[str]:
    """Return a line for every sonar topic that is used, and one for those that are not."""
    used = [sonar_info(bag, found, base, name, options) for name in options.sonar_topics]
    return [*used, *unused_sonars(bag, options)]


def _choose_sonars(bag: Bag, options: RecordingOptions) -> Choice:
    """Decide what of a bag without laser is used: odometry alone says where the robot is."""
    odom_topic, others = choose_odom_topic(bag, options) if options.use_odom else (None, "")
    found = survey(
        bag, options.sonar_topics[0], [*options.sonar_topics, *filter(None, [odom_topic])]
    )
    odom = found.first.get(odom_topic) if odom_topic else None
    base = robot_frame(found, odom, options)
    frame = tf_odometry(found, base, odom, options)
    sonars, odom_info = _all_or_errors(
        lambda: "; ".join(sonar_info(bag, found, base, n, options) for n in options.sonar_topics),
        lambda: odom_info_of(bag, found.tree, odom, odom_topic, frame, base, options),
    )
    unused = unused_sonars(bag, options)
    info = ("scans: none, sonars alone are mapped", odom_info + others, sonars, *unused)
    return Choice(
        "", options.sonar_topics, None if frame is not None else odom_topic, base, tf_topics(bag),
        base, frame, found.tree, fixed_links(found.tree, base), info,
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
        require(bag, options.scan_topic, SCAN_TYPE, "--scan-topic")
        return options.scan_topic, f"scans: {options.scan_topic}, as asked"
    names, echoes = names_of(bag, SCAN_TYPE), names_of(bag, ECHO_TYPE)
    passed = f"; MultiEchoLaserScan is passed over: {', '.join(echoes)}" if echoes else ""
    if not names:
        listed = ", ".join(f"{t.name} ({t.msgtype})" for t in bag.topics.values()) or "none"
        raise RecordingError(
            f"{bag.path} has no LaserScan messages{passed}{sonar_hint(bag)}; its topics: {listed}"
        )
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


def _add_description(
    bag: Bag, tree: FrameTree, scan_frame: str, odom: Any | None, options: RecordingOptions
) -> bool:
    """Add the fixed joints of a recorded robot description where TF does not reach the laser."""
    base = base_frame(tree, scan_frame, odom, options).name
    if tree.connects(base, scan_frame) or options.laser_pose is not None:
        return False
    topics = [n for n in names_of(bag, TEXT_TYPE) if n.endswith(DESCRIPTION_NAME)]
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
