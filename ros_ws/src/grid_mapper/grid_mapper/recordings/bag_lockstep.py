"""A bag's readings in lockstep: each waits for its transforms, in stamp order; none is lost."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import (
    PastExtrapolationError,
    TransformBuffer,
    TransformUnavailable,
)
from grid_mapper.laser_mount import level_scan
from grid_mapper.recordings.bag import Message
from grid_mapper.recordings.bag_choice import Choice
from grid_mapper.recordings.bag_frames import plain
from grid_mapper.recordings.bag_messages import (
    StampedTransform,
    is_infrared,
    odometry_from,
    range_event,
    stamp_ns_of,
    transforms_from,
)
from grid_mapper.recordings.bag_survey import is_static_topic
from grid_mapper.recordings.events import Event, Recording, RecordingOptions, ScanEvent
from grid_mapper.recordings.ordering import JUMP_NS, StampWatch
from grid_mapper.recordings.pose_track import PoseTrack
from grid_mapper.recordings.scan_geometry import scan_of

KEEP_ODOM_NS = 10_000_000_000
"""As long as transforms are kept: nothing is interpolated over a longer gap."""
LONGEST_WAIT_NS = 9_000_000_000
"""Odometry may run so far ahead of a waiting reading; those behind it then find theirs still."""


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
        for transform in choice.fixed.values():
            self._set_transform(transform, is_static=True)

    def take(self, message: Message, content: Any) -> Iterator[Event]:
        """Take one message; yield every event that it makes ready."""
        if message.topic in self._choice.tf_topics:
            self._take_transforms(message, content)
        elif message.topic == self._choice.odom_topic:
            self._take_odometry(message, content)
        else:
            self._take_reading(message, content)
        yield from self._ready()

    def finish(self) -> None:
        """Count what still waits when the bag has ended: nothing covers it."""
        self._counts.without_transform += len(self._waiting)
        self._waiting.clear()

    def _stamp_ns(self, message: Message, stamp_ns: int) -> int:
        return message.recorded_ns if self._options.use_recorded_stamps else stamp_ns

    def _take_transforms(self, message: Message, content: Any) -> None:
        is_static = is_static_topic(message.topic)
        for transform in transforms_from(content):
            parent, child, stamp_ns = transform[:3]
            if not is_static and (plain(parent), plain(child)) in self._choice.fixed:
                continue
            stamp_ns = self._stamp_ns(message, stamp_ns)
            if not is_static and plain(parent) == self._choice.odom_frame:
                self._watch_motion(child, stamp_ns)
            self._set_transform((parent, child, stamp_ns, *transform[3:]), is_static)

    def _set_transform(self, transform: StampedTransform, is_static: bool) -> None:
        try:
            self._buffer.set_transform(*transform, is_static)
        except ValueError:
            self._counts.malformed += 1

    def _watch_motion(self, source: str, stamp_ns: int) -> None:
        """Start again if the stamps of a frame or of the odometry jump back."""
        if stamp_ns == 0:
            return
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

    def _take_odometry(self, message: Message, content: Any) -> None:
        stamp_ns = self._stamp_ns(message, stamp_ns_of(content))
        try:
            T_odom_child = odometry_from(content).to_se2()
        except ValueError:
            self._counts.malformed += 1
            return
        self._watch_motion("odometry", stamp_ns)
        self._odom.add(stamp_ns, T_odom_child)
        self._odom.forget_before(stamp_ns - KEEP_ODOM_NS)

    def _take_reading(self, message: Message, content: Any) -> None:
        stamp_ns = self._stamp_ns(message, stamp_ns_of(content))
        is_scan = message.topic == self._choice.scan_topic
        if not is_scan and is_infrared(content):
            self._counts.infrared.add(plain(content.header.frame_id))
            return
        if stamp_ns == 0:
            self._counts.scans += is_scan
            self._counts.malformed += 1
            return
        jumped = is_scan and self._watch.is_jump(stamp_ns)
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
            except ValueError:
                self._counts.malformed += 1
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
            self._refuse_to_wait_longer(reading)
            return None
        if self._options.use_odom and T_odom_base is None:
            self._refuse_to_wait_longer(reading)
            return None
        if is_scan:
            return self._scan_event(reading, T_base_sensor, T_odom_base)
        return range_event(reading.stamp_ns, reading.message, T_base_sensor, T_odom_base)

    def _refuse_to_wait_longer(self, reading: Waiting) -> None:
        """Give a reading up if what it waits for can no longer come."""
        if max(self._newest_ns.values(), default=0) > reading.stamp_ns + LONGEST_WAIT_NS:
            raise NeverCoveredError

    def _scan_event(
        self, reading: Waiting, T_base_laser: Transform3, T_odom_base: SE2 | None
    ) -> ScanEvent:
        scan = scan_of(reading.message, self._options.range_limits_m)
        leveled, pose = level_scan(scan, T_base_laser)
        return ScanEvent(reading.stamp_ns, leveled, pose, T_odom_base, reading.follows_jump)

    def _sensor_pose(self, frame: str, is_scan: bool, stamp_ns: int) -> Transform3:
        if is_scan and self._options.laser_pose is not None:
            return Transform3.from_se2(self._options.laser_pose)
        given = dict(self._options.sonar_poses)
        if not is_scan and plain(frame) in given:
            return Transform3.from_se2(given[plain(frame)])
        base = self._choice.base_frame
        if plain(frame) == base:
            return Transform3.identity()
        if not self._choice.tree.connects(base, plain(frame)):
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
        if self._odom.gap_ns(stamp_ns) > KEEP_ODOM_NS:
            raise NeverCoveredError
        T_odom_child, child = self._odom.at(stamp_ns), self._choice.odom_child
        if T_odom_child is None or child == self._choice.base_frame:
            return T_odom_child
        return T_odom_child @ self._buffer.lookup(child, self._choice.base_frame, stamp_ns).to_se2()
