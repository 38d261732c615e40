"""What a bag's sonars need: their poses on the robot, and the robot's frame without a laser."""

from __future__ import annotations

from typing import Any

from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_frames import base_frame, plain
from grid_mapper.recordings.bag_survey import Survey
from grid_mapper.recordings.bag_types import RANGE_TYPE, SCAN_TYPE
from grid_mapper.recordings.events import RecordingError, RecordingOptions


def has_sonars_alone(bag: Bag, options: RecordingOptions) -> bool:
    """Tell whether sonars are asked for and the bag has no LaserScan."""
    has_scans = any(t.msgtype == SCAN_TYPE and t.num_messages for t in bag.topics.values())
    return bool(options.sonar_topics) and options.scan_topic is None and not has_scans


def unused_sonars(bag: Bag, options: RecordingOptions) -> list[str]:
    """Return what to say of Range topics that have messages and are not asked for: 0 or 1 text."""
    names = [name for name in _range_topics(bag) if name not in options.sonar_topics]
    if not names:
        return []
    asked = " ".join(f"--sonar-topic {name}" for name in names)
    return [f"not used: Range messages on {', '.join(names)}; if they are sonars: {asked}"]


def _range_topics(bag: Bag) -> list[str]:
    return [t.name for t in bag.topics.values() if t.msgtype == RANGE_TYPE and t.num_messages]


def sonar_hint(bag: Bag) -> str:
    """Return how a bag without laser can be mapped; "" if it has no sonars either."""
    names = _range_topics(bag)
    return f"; map its sonars alone with --sonar-topic {' or '.join(names)}" if names else ""


def sonar_info(bag: Bag, found: Survey, base: str, name: str, options: RecordingOptions) -> str:
    """Return where the poses of a topic's sonars are from.

    Raises:
        RecordingError: If those of the first message's sonar are not known.
    """
    first = found.first.get(name)
    if first is None:
        raise RecordingError(
            f"{bag.path}: no message on {name} can be read: leave out --sonar-topic {name}"
        )
    frame = plain(first.header.frame_id)
    given = [each for each, _ in options.sonar_poses]
    if frame in given:
        return f"sonar: {name}, poses of {', '.join(given)} as given on the command line"
    if found.tree.connects(base, frame):
        return f"sonar: {name}, TF {base} -> {frame} and others of that topic"
    raise RecordingError(
        f"{bag.path} has no transform from {base} to {frame!r}: leave out --sonar-topic {name}, or"
        f" say where it sits with --sonar-pose {frame} X Y YAW (m, m, rad), one for each frame"
    )


def robot_frame(found: Survey, odom: Any | None, options: RecordingOptions) -> str:
    """Return the robot's frame in a bag without laser: above the first sonar, or of odometry."""
    frame = plain(found.first[options.sonar_topics[0]].header.frame_id)
    chosen = base_frame(found.tree, frame, odom, options)
    child = "" if odom is None else plain(str(odom.child_frame_id))
    is_known = found.tree.connects(chosen.name, frame) or options.base_frame is not None
    return chosen.name if is_known or not child else child
