"""What is in a recording, as text: topics, types, rates, and which of them would be used."""

from __future__ import annotations

from pathlib import Path

from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_choice import Choice, choose
from grid_mapper.recordings.bag_files import is_bag
from grid_mapper.recordings.events import RecordingError, RecordingOptions
from grid_mapper.recordings.formats import open_recording


def describe_recording(path: Path, options: RecordingOptions) -> list[str]:
    """Return lines that tell what a recording holds.

    Raises:
        RecordingError: If it cannot be read at all.
    """
    if not path.exists() or not is_bag(path):
        recording = open_recording(path, options)
        return [f"{path.name}: {recording.format}, {recording.num_scans} scans", *recording.info]
    with Bag(path) as bag:
        try:
            choice: Choice | None = choose(bag, options)
            notes = list(choice.info) if choice is not None else []
        except RecordingError as error:
            choice, notes = None, [f"not yet usable: {error}"]
        return [*_topic_lines(bag, choice), *notes, *bag.problems]


def _topic_lines(bag: Bag, choice: Choice | None) -> list[str]:
    kind = "ROS 1 bag" if bag.is_ros1 else "rosbag2"
    duration_s = bag.duration_ns * 1e-9
    lines = [f"{bag.path.name}: {kind}, {bag.num_messages} messages, {duration_s:.1f} s"]
    used = _used_topics(choice)
    width = max((len(name) for name in bag.topics), default=0)
    for topic in bag.topics.values():
        rate = topic.num_messages / duration_s if duration_s > 0.0 else 0.0
        mark = "*" if topic.name in used else " "
        counts = f"{topic.num_messages:6d} {rate:7.1f} Hz"
        lines.append(f" {mark} {topic.name:<{width}} {counts}  {topic.msgtype}")
    lines.append("topics marked * would be used")
    return lines


def _used_topics(choice: Choice | None) -> set[str]:
    if choice is None:
        return set()
    odom = [] if choice.odom_topic is None else [choice.odom_topic]
    return {choice.scan_topic, *choice.sonar_topics, *choice.tf_topics, *odom}
