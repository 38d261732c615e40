"""What a bag's scans, transforms and odometry are like, from one pass over them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from floornav_common.transform_buffer import clean_frame
from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_messages import StampedTransform, stamp_ns_of, transforms_from
from grid_mapper.recordings.bag_types import OLD_TF_TYPE, TF_TYPE

NUM_LAGS = 1001
SAME_TRANSFORM = 1e-6
"""Numbers (m, quaternion) that differ by less are the same: drivers compute them anew each time."""


@dataclass
class Span:
    """Stamps of one source.

    Attributes:
        oldest_ns: First in time.
        newest_ns: Last in time.
        num: How many were not zero.
        num_zero: How many were zero: never set by the driver.
        latest_ns: Last as recorded.
        recorded_from_ns: When the first was recorded.
        recorded_to_ns: When the last was recorded.
        lags_ns: Stamps of the first scans recorded after it minus the latest stamp by then.
    """

    oldest_ns: int = 2**63 - 1
    newest_ns: int = -(2**63)
    num: int = 0
    num_zero: int = 0
    latest_ns: int = 0
    recorded_from_ns: int = 0
    recorded_to_ns: int = 0
    lags_ns: list[int] = field(default_factory=list)

    def add(self, stamp_ns: int, recorded_ns: int) -> None:
        """Take one stamp."""
        if stamp_ns == 0:
            self.num_zero += 1
            return
        if self.num == 0:
            self.recorded_from_ns = recorded_ns
        self.num += 1
        self.oldest_ns = min(self.oldest_ns, stamp_ns)
        self.newest_ns = max(self.newest_ns, stamp_ns)
        self.latest_ns, self.recorded_to_ns = stamp_ns, recorded_ns

    def note_scan(self, stamp_ns: int) -> None:
        """Note how far the stamp of a scan is from the latest one recorded before it."""
        if self.num > 0 and stamp_ns != 0 and len(self.lags_ns) < NUM_LAGS:
            self.lags_ns.append(stamp_ns - self.latest_ns)

    @property
    def speed(self) -> float:
        """How fast stamps run by the recorder's clock: 4 if replayed at four times the speed."""
        recorded_ns = self.recorded_to_ns - self.recorded_from_ns
        return (self.newest_ns - self.oldest_ns) / recorded_ns if recorded_ns > 0 else 1.0

    def overlaps(self, other: Span) -> bool:
        """Tell whether two sources share any time."""
        return self.oldest_ns <= other.newest_ns and other.oldest_ns <= self.newest_ns


@dataclass
class Link:
    """All transforms from one frame to another.

    Attributes:
        first: The first one recorded.
        span: Their stamps.
        is_static: Whether one came on a static topic.
        is_constant: Whether all are the same.
    """

    first: StampedTransform
    span: Span = field(default_factory=Span)
    is_static: bool = False
    is_constant: bool = True

    def add(self, transform: StampedTransform, recorded_ns: int, is_static: bool) -> None:
        """Take one transform."""
        numbers = (*transform[3], *transform[4])
        first = (*self.first[3], *self.first[4])
        if any(abs(a - b) > SAME_TRANSFORM for a, b in zip(numbers, first, strict=True)):
            self.is_constant = False
        self.is_static |= is_static
        self.span.add(transform[2], recorded_ns)


@dataclass
class FrameTree:
    """Which frames hang together at any time of the bag.

    Attributes:
        links: By parent and child.
        groups: For each frame all that it hangs together with.
    """

    links: dict[tuple[str, str], Link] = field(default_factory=dict)
    groups: dict[str, set[str]] = field(default_factory=dict)

    def add(self, transform: StampedTransform, recorded_ns: int, is_static: bool) -> None:
        """Note a transform; one without frame ids is left out."""
        if not (transform[0].strip("/") and transform[1].strip("/")):
            return
        pair = clean_frame(transform[0]), clean_frame(transform[1])
        if pair not in self.links:
            self.links[pair] = Link(transform)
            group = self.groups.get(pair[0], {pair[0]}) | self.groups.get(pair[1], {pair[1]})
            for frame in group:
                self.groups[frame] = group
        self.links[pair].add(transform, recorded_ns, is_static)

    def connects(self, a: str, b: str) -> bool:
        """Tell whether a chain of recorded transforms joins two frames, or they are one."""
        return bool(a) and (a == b or b in self.groups.get(a, ()))

    def above(self, frame: str) -> list[str]:
        """Return a frame and its ancestors, nearest first, by the first parent of each."""
        chain = [frame]
        while (parent := self._parent(chain[-1])) is not None and parent not in chain:
            chain.append(parent)
        return chain

    def between(self, a: str, b: str) -> list[Link]:
        """Return the links on the way from one frame to another."""
        up, down = self.above(a), self.above(b)
        meets = next((frame for frame in up if frame in down), None)
        if meets is None:
            return []
        ways = up[: up.index(meets) + 1], down[: down.index(meets) + 1]
        pairs = [(way[i + 1], way[i]) for way in ways for i in range(len(way) - 1)]
        return [self.links[pair] for pair in pairs]

    def _parent(self, frame: str) -> str | None:
        return next((parent for parent, child in self.links if child == frame), None)


@dataclass
class Survey:
    """What was found.

    Attributes:
        tree: Of all transforms.
        first: First readable message of each surveyed topic; of scans one with ranges.
        spans: Stamps of each surveyed topic but those of transforms.
    """

    tree: FrameTree = field(default_factory=FrameTree)
    first: dict[str, Any] = field(default_factory=dict)
    spans: dict[str, Span] = field(default_factory=dict)

    def note_scan(self, scan_topic: str, stamp_ns: int) -> None:
        """Tell all other sources of the stamp of a scan."""
        for link in self.tree.links.values():
            link.span.note_scan(stamp_ns)
        for topic, span in self.spans.items():
            if topic != scan_topic:
                span.note_scan(stamp_ns)


def is_static_topic(name: str) -> bool:
    """Tell whether transforms of a topic hold at any time."""
    return name.endswith("tf_static")


def tf_topics(bag: Bag) -> tuple[str, ...]:
    """Return the topics that carry transforms."""
    return tuple(t.name for t in bag.topics.values() if t.msgtype in (TF_TYPE, OLD_TF_TYPE))


def survey(bag: Bag, scan_topic: str, others: Iterable[str]) -> Survey:
    """Go over a bag's transforms and some of its stamped topics.

    Args:
        bag: The bag.
        scan_topic: Name of the topic of its scans.
        others: Names of other topics whose messages have a header.
    """
    found = Survey(spans={name: Span() for name in (scan_topic, *others)})
    transforms = tf_topics(bag)
    for topic, recorded_ns, content in _contents(bag, {*transforms, *found.spans}):
        if len(getattr(content, "ranges", "any")) > 0:
            found.first.setdefault(topic, content)
        if topic in found.spans:
            found.spans[topic].add(stamp_ns_of(content), recorded_ns)
            if topic == scan_topic:
                found.note_scan(scan_topic, stamp_ns_of(content))
            continue
        for transform in transforms_from(content):
            found.tree.add(transform, recorded_ns, is_static_topic(topic))
    return found


def _contents(bag: Bag, topics: set[str]) -> Iterator[tuple[str, int, Any]]:
    for message in bag.messages(topics) if topics else ():
        try:
            yield message.topic, message.recorded_ns, bag.deserialize(message)
        except ValueError:
            continue
