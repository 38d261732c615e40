"""Which topics of a bag are there to choose from, and what gives its odometry."""

from __future__ import annotations

from typing import Any

from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_frames import never_moves, odom_child, odom_frame
from grid_mapper.recordings.bag_survey import FrameTree, Survey
from grid_mapper.recordings.bag_types import ODOM_TYPE
from grid_mapper.recordings.events import RecordingError, RecordingOptions

ODOM_TOPIC = "/odom"


def names_of(bag: Bag, msgtype: str) -> list[str]:
    """Return the topics of a type that have messages."""
    return [t.name for t in bag.topics.values() if t.msgtype == msgtype and t.num_messages > 0]


def require(bag: Bag, name: str, msgtype: str, option: str) -> None:
    """Raise unless a topic is there, of its type and with messages."""
    topic = bag.topics.get(name)
    if topic is not None and topic.msgtype == msgtype and topic.num_messages > 0:
        return
    known = ", ".join(names_of(bag, msgtype)) or "none"
    state = "has no topic" if topic is None else f"has no {msgtype} message on topic"
    raise RecordingError(f"{bag.path} {state} {name} ({option}); topics of that type: {known}")


def choose_odom_topic(bag: Bag, options: RecordingOptions) -> tuple[str | None, str]:
    """Return the Odometry topic, None if there is not one that stands out; and which it is not."""
    if options.odom_topic is not None:
        require(bag, options.odom_topic, ODOM_TYPE, "--odom-topic")
        return options.odom_topic, ""
    names = names_of(bag, ODOM_TYPE)
    if len(names) == 1:
        return names[0], ""
    if ODOM_TOPIC in names:
        others = ", ".join(n for n in names if n != ODOM_TOPIC)
        return ODOM_TOPIC, f" (not {others}: --odom-topic to change)"
    return None, ""


def tf_odometry(
    found: Survey, base: str, odom: Any | None, options: RecordingOptions
) -> str | None:
    """Return the frame by which TF gives the odometry; None if it does not, or shall not."""
    if not options.use_odom or options.odom_topic is not None:
        return None
    frame = odom_frame(found.tree, base, odom, options)
    is_stand_in = frame is not None and never_moves(found.tree, frame, base)
    return None if is_stand_in and options.odom_frame is None else frame


def odom_info_of(
    bag: Bag,
    tree: FrameTree,
    odom: Any | None,
    odom_topic: str | None,
    odom_frame: str | None,
    base: str,
    options: RecordingOptions,
) -> str:
    """Return where the odometry is from.

    Raises:
        RecordingError: If nothing says it and the user does not either.
    """
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
    names = names_of(bag, ODOM_TYPE)
    above = [frame for frame in tree.above(base)[1:] if frame != options.odom_frame]
    cures = [f"choose with --odom-topic {' or '.join(names)}"] if names else []
    if above and not names:
        cures.append(f"--odom-frame {above[-1]} takes what moves {base} there as odometry")
    cures.append("map without: --no-odom")
    raise RecordingError(
        f"{bag.path} has no moving transform from {options.odom_frame or 'odom'} to {base}"
        f" and no single Odometry topic: {', or '.join(cures)}"
    )
