"""Any ROS message in one line for people: poses as x, y, yaw; everything else as names and values.

Messages are only looked at, so nothing of ROS is imported here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

_MOST_CHARS = 240
_MOST_POSES = 8
_MOST_VALUES = 4
_YAW_AT = 35  # of a 6 x 6 covariance, row by row


def one_line(msg: Any) -> str:
    """Return a message in one line.

    Args:
        msg: Of any type that rclpy generates, or whatever has the same attributes.
    """
    parts = []
    header = getattr(msg, "header", None)
    if header is not None:
        parts.append(
            f"{header.stamp.sec + header.stamp.nanosec / 1e9:.3f} s in {header.frame_id!r}:"
        )
    parts.append(_body(msg))
    text = " ".join(parts)
    return text if len(text) <= _MOST_CHARS else text[: _MOST_CHARS - 4] + " ..."


def _body(msg: Any) -> str:
    if hasattr(msg, "poses"):
        poses = [getattr(p, "pose", p) for p in msg.poses]
        more = "; ..." if len(poses) > _MOST_POSES else ""
        listed = "; ".join(_pose(pose) for pose in poses[:_MOST_POSES])
        return f"{len(poses)} poses" + (f": {listed}{more}" if poses else "")
    pose = getattr(msg, "pose", None)
    if pose is not None and hasattr(pose, "covariance"):
        return f"{_pose(pose.pose)}, {_deviations(pose.covariance)}"
    if pose is not None and hasattr(pose, "orientation"):
        return _pose(pose)
    return ", ".join(f"{name} {value}" for name, value in _values(msg, "")) or "(empty)"


def _pose(pose: Any) -> str:
    p, q = pose.position, pose.orientation
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
    return f"x {p.x:.3f} y {p.y:.3f} m yaw {math.degrees(yaw):.1f} deg"


def _deviations(covariance: Sequence[float]) -> str:
    xx, yy, turn = covariance[0], covariance[7], covariance[_YAW_AT]
    if not min(xx, yy, turn) >= 0.0:
        return "no covariance"
    sd = f"{math.sqrt(xx):.3f} {math.sqrt(yy):.3f} m {math.degrees(math.sqrt(turn)):.2f} deg"
    return f"deviations {sd}"


def _values(value: Any, name: str) -> Iterator[tuple[str, str]]:
    """Yield names with dots, and values, of all fields but the header."""
    fields = getattr(value, "get_fields_and_field_types", None)
    if fields is not None:
        for key in fields():
            if key != "header" or name:
                yield from _values(getattr(value, key), f"{name}.{key}".lstrip("."))
    elif isinstance(value, float):
        yield name, f"{value:.6g}"
    elif isinstance(value, str | bytes | bool | int | np.generic):
        yield name, str(value) if not isinstance(value, bytes) else str(list(value))
    else:
        yield from _list(list(value[:_MOST_VALUES]), len(value), name)


def _list(first: list[Any], num: int, name: str) -> Iterator[tuple[str, str]]:
    if first and hasattr(first[0], "get_fields_and_field_types"):
        inner = "; ".join(" ".join(f"{k} {v}" for k, v in _values(each, "")) for each in first)
    else:
        inner = ", ".join(text for each in first for _, text in _values(each, ""))
    yield name, f"[{inner}{', ...' if num > len(first) else ''}] ({num})"
