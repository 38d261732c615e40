"""A bag as a recording: its messages through the lockstep."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_choice import Choice, choose
from grid_mapper.recordings.bag_lockstep import Lockstep
from grid_mapper.recordings.events import Event, Recording, RecordingOptions


def open_bag_recording(path: Path, options: RecordingOptions) -> Recording:
    """Open a rosbag2 or ROS 1 bag.

    Raises:
        RecordingError: If it cannot be read, or leaves open what only the user can say.
    """
    bag = Bag(path)
    try:
        choice = choose(bag, options)
    except BaseException:
        bag.close()
        raise
    num_scans = bag.topics[choice.scan_topic].num_messages if choice.scan_topic else 0

    def source(recording: Recording) -> Iterator[Event]:
        with bag:
            yield from _events(bag, choice, options, recording)

    name = "ROS 1 bag" if bag.is_ros1 else "rosbag2"
    return Recording(name, list(choice.info), source, num_scans)


def _events(
    bag: Bag, choice: Choice, options: RecordingOptions, recording: Recording
) -> Iterator[Event]:
    lockstep = Lockstep(choice, options, recording)
    single = {name for name in (choice.scan_topic, choice.odom_topic) if name}
    topics = {*single, *choice.sonar_topics, *choice.tf_topics}
    for message in bag.messages(topics):
        try:
            content = bag.deserialize(message)
        except ValueError:
            recording.counts.malformed += 1
            continue
        yield from lockstep.take(message, content)
    lockstep.finish()
    recording.problem = "; ".join(bag.problems) or None
