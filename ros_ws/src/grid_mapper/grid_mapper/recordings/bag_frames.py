"""Which frames of a bag are the robot and its odometry, and what of them never moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grid_mapper.recordings.bag_messages import StampedTransform
from grid_mapper.recordings.bag_survey import FrameTree
from grid_mapper.recordings.events import RecordingOptions

BASE_NAME = "base_link"
FOOTPRINT_NAME = "base_footprint"
ODOM_NAME = "odom"
BASE_NAMES = (BASE_NAME, FOOTPRINT_NAME)


@dataclass(frozen=True)
class Frame:
    """A frame that was chosen, and why it is not the usual one ("" if it is)."""

    name: str
    why: str = ""


def plain(frame: str) -> str:
    """Return a frame id without the leading '/' of ROS 1; it may be empty."""
    return frame.removeprefix("/")


def last_part(frame: str) -> str:
    """Return a frame's name without the robot's before it."""
    return frame.rpartition("/")[2]


def odom_child(odom: Any | None) -> str:
    """Return the frame whose pose an Odometry message gives; "" if it does not say."""
    return "" if odom is None else plain(str(odom.child_frame_id))


def base_frame(
    tree: FrameTree, scan_frame: str, odom: Any | None, options: RecordingOptions
) -> Frame:
    """Choose the robot's frame: as asked, else base_link, else what the bag has in its place."""
    if options.base_frame is not None:
        return Frame(plain(options.base_frame))
    if tree.connects(BASE_NAME, scan_frame):
        return Frame(BASE_NAME)
    instead = f"there is no {BASE_NAME} above {scan_frame}; --base-frame to change"
    child = odom_child(odom)
    if child and tree.connects(child, scan_frame):
        return Frame(child, f"the odometry's child frame: {instead}")
    above = tree.above(scan_frame)
    for wanted in BASE_NAMES:
        for frame in above:
            if last_part(frame) == wanted:
                return Frame(frame, instead)
    for frame, parent in zip(above, above[1:], strict=False):
        if is_odom_name(parent):
            return Frame(frame, f"child of {parent}: {instead}")
    if child and options.laser_pose is not None:
        return Frame(child)
    return Frame(BASE_NAME)


def is_odom_name(frame: str) -> bool:
    """Tell whether a frame is named as odometry is: odom, odom_combined, robot1/odom."""
    return last_part(frame).startswith(ODOM_NAME)


def odom_frame(
    tree: FrameTree, base: str, odom: Any | None, options: RecordingOptions
) -> str | None:
    """Choose the odometry's frame in TF; None if there is none that TF joins to the robot."""
    if options.odom_frame is not None:
        wanted = plain(options.odom_frame)
        return wanted if tree.connects(wanted, base) else None
    header = "" if odom is None else plain(str(odom.header.frame_id))
    named = [frame for frame in tree.above(base)[1:] if is_odom_name(frame)]
    return next((f for f in (ODOM_NAME, header, *named) if f and tree.connects(f, base)), None)


def never_moves(tree: FrameTree, odom: str, base: str) -> bool:
    """Tell of an odometry that is only a static transform: a stand-in, no measurement."""
    links = tree.between(odom, base)
    return bool(links) and all(link.is_static for link in links)


def fixed_links(tree: FrameTree, base: str) -> dict[tuple[str, str], StampedTransform]:
    """Return the transforms that can be taken as valid at any time, by parent and child.

    These are the static ones, and those below the robot's frame that were sent as moving ones but
    are the same in the whole bag.
    """
    above = tree.above(base)
    return {
        pair: link.first
        for pair, link in tree.links.items()
        if link.is_static or (link.is_constant and pair[1] not in above)
    }
