"""A bag's scans in lockstep: each waits for its transforms, in stamp order; none is lost."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import (
    PastExtrapolationError,
    TransformBuffer,
    TransformUnavailable,
)
from grid_mapper.recordings.bag import Bag, Message
from grid_mapper.recordings.bag_choice import Choice, choose, is_static_topic
from grid_mapper.recordings.bag_messages import (
    StampedTransform,
    odometry_from,
    range_event,
    scan_event,
    stamp_ns_of,
    transforms_from,
)
from grid_mapper.recordings.events import Event, Recording, RecordingOptions
from grid_mapper.recordings.ordering import JUMP_NS, StampWatch
from grid_mapper.recordings.pose_track import PoseTrack

KEEP_ODOM_NS = 10_000_000_000


class NeverCoveredError(Exception):
    """No transform will come for a stamp any more."""


@dataclass(order=True)
class Waiting:
    """A scan or range that waits for its transforms; sorts by stamp, then as recorded."""

    stamp_ns: int
    number: int
    message: Any = field(compare=False)
    topic: str = field(compare=False)
    follows_jump: bool = field(compare=False)


class Lockstep:
    """Takes a bag's messages in recorded order and gives events as their transforms come."""

    def __init__(self, choice: Choice, options: RecordingOptions, recording: Recording) -> None:
        """Start with an empty buffer."""
        self._choice = choice
        self._options = options
        self._counts = recording.counts
        self._watch = StampWatch(recording.counts)
        self._buffer = TransformBuffer()
        self._odom = PoseTrack()
        self._waiting: list[Waiting] = []
        self._num_taken = 0
        self._newest_ns: dict[str, int] = {}
        self._has_restarted = False
        self._set_transforms(choice.tree.statics.values(), is_static=True)

    def take(self, message: Message, content: Any) -> Iterator[Event]:
        """Take one message; yield every event that it makes ready."""
        if message.topic in self._choice.tf_topics:
            self._set_transforms(transforms_from(content), is_static_topic(message.topic))
        elif message.topic == self._choice.odom_topic:
            self._take_odometry(content)
        else:
            self._take_reading(message, content)
        yield from self._ready()

    def finish(self) -> None:
        """Count what still waits when the bag has ended: nothing covers it."""
        self._counts.without_transform += len(self._waiting)
        self._waiting.clear()

    def _set_transforms(self, transforms: Iterable[StampedTransform], is_static: bool) -> None:
        for parent, child, stamp_ns, xyz, quat_xyzw in transforms:
            if not is_static and parent.removeprefix("/") == self._choice.odom_frame:
                self._watch_motion(child, stamp_ns)
            try:
                self._buffer.set_transform(parent, child, stamp_ns, xyz, quat_xyzw, is_static)
            except ValueError:
                self._counts.malformed += 1

    def _watch_motion(self, source: str, stamp_ns: int) -> None:
        """Start again if the stamps of a frame or of the odometry jump back."""
        newest_ns = self._newest_ns.get(source, stamp_ns)
        if newest_ns - stamp_ns > JUMP_NS:
            self._restart()
            self._has_restarted = True
        self._newest_ns[source] = max(self._newest_ns.get(source, stamp_ns), stamp_ns)

    def _restart(self) -> None:
        """Forget what belongs to the time before a jump; readings that still wait are counted."""
        self.finish()
        self._buffer.clear()
        self._odom.clear()
        self._newest_ns.clear()

    def _take_odometry(self, content: Any) -> None:
        stamp_ns, T_odom_base = odometry_from(content)
        self._watch_motion("odometry", stamp_ns)
        self._odom.add(stamp_ns, T_odom_base)
        self._odom.forget_before(stamp_ns - KEEP_ODOM_NS)

    def _take_reading(self, message: Message, content: Any) -> None:
        stamp_ns = stamp_ns_of(content)
        jumped = message.topic == self._choice.scan_topic and self._watch.is_jump(stamp_ns)
        if jumped and not self._has_restarted:
            self._restart()
        if jumped:
            self._has_restarted = False
        self._num_taken += 1
        reading = Waiting(stamp_ns, self._num_taken, content, message.topic, jumped)
        heapq.heappush(self._waiting, reading)

    def _ready(self) -> Iterator[Event]:
        """Yield the oldest waiting readings for which all transforms are there."""
        while self._waiting:
            reading = self._waiting[0]
            try:
                event = self._event(reading)
            except NeverCoveredError:
                self._counts.without_transform += 1
            else:
                if event is None:
                    return
                yield event
            heapq.heappop(self._waiting)

    def _event(self, reading: Waiting) -> Event | None:
        """Return the event of a reading; None while a transform may still come."""
        frame = reading.message.header.frame_id
        is_scan = reading.topic == self._choice.scan_topic
        try:
            T_base_sensor = self._sensor_pose(frame, is_scan, reading.stamp_ns)
            T_odom_base = self._odometry(reading.stamp_ns)
        except PastExtrapolationError as error:
            raise NeverCoveredError from error
        except TransformUnavailable:
            return None
        if self._options.use_odom and T_odom_base is None:
            return None
        if is_scan:
            return scan_event(reading.message, T_base_sensor, T_odom_base, reading.follows_jump)
        return range_event(reading.message, T_base_sensor, T_odom_base)

    def _sensor_pose(self, frame: str, is_scan: bool, stamp_ns: int) -> Transform3:
        if is_scan and self._options.laser_pose is not None:
            return Transform3.from_se2(self._options.laser_pose)
        base = self._choice.base_frame
        if not self._choice.tree.connects(base, frame.removeprefix("/")):
            raise NeverCoveredError
        return self._buffer.lookup(base, frame, stamp_ns)

    def _odometry(self, stamp_ns: int) -> SE2 | None:
        if not self._options.use_odom:
            return None
        if self._choice.odom_frame is not None:
            frames = (self._choice.odom_frame, self._choice.base_frame)
            return self._buffer.lookup(*frames, stamp_ns).to_se2()
        oldest_ns = self._odom.oldest_ns()
        if oldest_ns is not None and stamp_ns < oldest_ns:
            raise NeverCoveredError
        return self._odom.at(stamp_ns)


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
    num_scans = bag.topics[choice.scan_topic].num_messages

    def source(recording: Recording) -> Iterator[Event]:
        with bag:
            yield from _events(bag, choice, options, recording)

    name = "ROS 1 bag" if bag.is_ros1 else "rosbag2"
    return Recording(name, list(choice.info), source, num_scans)


def _events(
    bag: Bag, choice: Choice, options: RecordingOptions, recording: Recording
) -> Iterator[Event]:
    lockstep = Lockstep(choice, options, recording)
    topics = {choice.scan_topic, *choice.sonar_topics, *choice.tf_topics}
    topics |= {choice.odom_topic} if choice.odom_topic else set()
    for message in bag.messages(topics):
        try:
            content = bag.deserialize(message)
        except ValueError:
            recording.counts.malformed += 1
            continue
        yield from lockstep.take(message, content)
    lockstep.finish()
    recording.problem = "; ".join(bag.problems) or None
