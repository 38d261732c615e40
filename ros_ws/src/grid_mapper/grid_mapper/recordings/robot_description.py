"""Where sensors sit by a URDF: the joints that do not move, as transforms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

from grid_mapper.recordings.bag_messages import StampedTransform


def fixed_transforms(urdf: str) -> list[StampedTransform]:
    """Return a transform for each fixed joint of a robot description; none if it is not readable.

    Args:
        urdf: XML as on the topic `robot_description`.
    """
    try:
        return list(_fixed(ElementTree.fromstring(urdf)))
    except (ElementTree.ParseError, ValueError):
        return []


def _fixed(robot: ElementTree.Element) -> Iterator[StampedTransform]:
    for joint in robot.iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if joint.get("type") != "fixed" or parent is None or child is None:
            continue
        origin = joint.find("origin")
        xyz = _numbers(origin, "xyz")
        rpy = _numbers(origin, "rpy")
        yield parent.get("link", ""), child.get("link", ""), 0, xyz, quat_of_rpy(*rpy)


def _numbers(element: ElementTree.Element | None, name: str) -> tuple[float, ...]:
    text = "0 0 0" if element is None else element.get(name, "0 0 0")
    numbers = tuple(float(word) for word in text.split())
    if len(numbers) != 3:
        raise ValueError(f"{name} must hold three numbers, got {text!r}")
    return numbers


def quat_of_rpy(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of turns about the fixed axes x, then y, then z."""
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    cp, sp = math.cos(pitch / 2.0), math.sin(pitch / 2.0)
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
