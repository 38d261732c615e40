"""What is played of a bag, and when: from any point, latched messages included."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from rosbags.interfaces import Qos, QosDurability

from grid_mapper.recordings.bag import Bag, Message, Topic
from grid_mapper.recordings.bag_files import unpacked_message

STATIC_NAME = "tf_static"


@dataclass(frozen=True)
class PlayWindow:
    """The part of a bag that is played.

    Attributes:
        start_ns: Recorded time at which it begins.
        end_ns: Recorded time at which it ends; that instant is still played.
    """

    start_ns: int
    end_ns: int


def play_window(bag: Bag, start_s: float, duration_s: float | None) -> PlayWindow:
    """Return the window that begins `start_s` after the bag's start.

    Raises:
        ValueError: If the bag is over by then.
    """
    start_ns = bag.start_ns + round(start_s * 1e9)
    end_ns = bag.start_ns + bag.duration_ns
    if start_ns > end_ns:
        raise ValueError(f"--start {start_s:g} s is behind the end, {bag.duration_ns * 1e-9:.1f} s")
    if duration_s is not None:
        end_ns = min(end_ns, start_ns + round(duration_s * 1e9))
    return PlayWindow(start_ns, end_ns)


def is_latched(topic: Topic) -> bool:
    """Tell whether late subscribers get a topic's messages; by its QoS, tf_static by its name."""
    if not topic.qos:
        return topic.name.endswith(STATIC_NAME)
    return any(profile.durability == QosDurability.TRANSIENT_LOCAL for profile in topic.qos)


def latched_before(bag: Bag, topics: Collection[str], start_ns: int) -> list[Message]:
    """Return the messages that a subscriber starting at a time would be given at once.

    Of a latched topic the last message; of static transforms all, for several nodes send them.

    Args:
        bag: The bag.
        topics: Names of the topics that are played.
        start_ns: Recorded time of the start.
    """
    names = [name for name in topics if is_latched(bag.topics[name])]
    kept: dict[str, list[Message]] = {name: [] for name in names}
    for message in bag.messages(names) if names else ():
        if message.recorded_ns >= start_ns:
            break
        if not message.topic.endswith(STATIC_NAME):
            kept[message.topic].clear()
        kept[message.topic].append(_unpacked(message))
    messages = [message for of_topic in kept.values() for message in of_topic]
    return sorted(messages, key=lambda message: message.recorded_ns)


def messages_within(bag: Bag, topics: Collection[str], window: PlayWindow) -> Iterator[Message]:
    """Yield the messages of a window in recorded order, unpacked."""
    for message in bag.messages(topics, start_ns=window.start_ns):
        if message.recorded_ns > window.end_ns:
            return
        yield _unpacked(message)


def offered_profile(topic: Topic) -> Qos | None:
    """Return the profile to offer for a topic; None where none was recorded.

    Publishers of one topic may have offered different ones: then the strongest of each policy is
    offered, which suits every subscriber that one of them suited.
    """
    if not topic.qos:
        return None
    first, *others = topic.qos
    for other in others:
        first = first._replace(
            reliability=min(first.reliability, other.reliability, key=_strength),
            durability=min(first.durability, other.durability, key=_strength),
            depth=max(first.depth, other.depth),
        )
    return first


def _strength(policy: object) -> int:
    """Order reliable before best effort, transient local before volatile; unknown ones last."""
    value = int(getattr(policy, "value", 0))
    return value if value in (1, 2) else 9


def _unpacked(message: Message) -> Message:
    return message._replace(data=unpacked_message(message.data))
