"""Messages of the planner <-> core types."""

from __future__ import annotations

from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Path
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from floornav_common.ros.messages import se2_to_pose
from floornav_common.se2 import SE2
from sjmc_planner.planning import Debug, Velocity

_GROWN, _OPEN, _SHUT, _CHOSEN, _ZONE, _PERSON, _COUNTS, _TEXT = (
    (0.9, 0.4, 0.1, 0.9), (0.2, 0.7, 0.3, 0.6), (0.6, 0.6, 0.6, 0.4), (0.1, 0.3, 1.0, 1.0),
    (0.9, 0.7, 0.1, 0.8), (0.8, 0.1, 0.6, 1.0), (1.0, 0.1, 0.1, 1.0), (1.0, 1.0, 1.0, 1.0),
)  # fmt: skip
_LINE_M, _LETTER_M = 0.01, 0.15
_ABOVE_M = 0.8  # the text over the floor


def velocity_from_msg(msg: Any) -> Velocity:
    """Return the planar part of a Twist.

    Raises:
        ValueError: If a number is not finite.
    """
    values = (float(msg.linear.x), float(msg.linear.y), float(msg.angular.z))
    if not np.isfinite(values).all():
        raise ValueError(f"the twist must be finite, got {values}")
    return Velocity(*values)


def velocity_to_msg(velocity: Velocity) -> Twist:
    """Return a velocity as a Twist."""
    msg = Twist()
    msg.linear.x, msg.linear.y = float(velocity.x), float(velocity.y)
    msg.angular.z = float(velocity.yaw_rate)
    return msg


def velocity_to_stamped_msg(velocity: Velocity, stamp: Any, frame_id: str) -> TwistStamped:
    """Return a velocity as a TwistStamped."""
    msg = TwistStamped(twist=velocity_to_msg(velocity))
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    return msg


def path_points(msg: Any) -> np.ndarray:
    """Return the places of a nav_msgs/Path, shape (N, 2), m."""
    places = [(p.pose.position.x, p.pose.position.y) for p in msg.poses]
    return np.array(places, dtype=float).reshape(-1, 2)


def path_to_msg(points: np.ndarray, frame_id: str, stamp: Any) -> Path:
    """Return places, shape (N, 2), as a nav_msgs/Path; each pose looks along the way."""
    msg = Path()
    msg.header.frame_id, msg.header.stamp = frame_id, stamp
    legs = np.diff(points, axis=0) if len(points) > 1 else np.tile([1.0, 0.0], (len(points), 1))
    yaws = np.arctan2(legs[:, 1], legs[:, 0])
    yaws = np.append(yaws, yaws[-1:])[: len(points)]
    for (x, y), yaw in zip(points, yaws, strict=True):
        pose = PoseStamped(header=msg.header, pose=se2_to_pose(SE2(float(x), float(y), float(yaw))))
        msg.poses.append(pose)
    return msg


def state_to_msg(
    name: str, level: bytes, state: str, reason: str, waited_s: float, left_m: float | None,
    goal: str = "",
) -> DiagnosticStatus:  # fmt: skip
    """Return what the planner says on `planner/state`; the goal as `goal_name` gives it."""
    values = {
        "state": state,
        "reason": reason,
        "waited (s)": f"{waited_s:.1f}",
        "distance left (m)": "" if left_m is None else f"{left_m:.2f}",
        "goal": goal,
    }
    return DiagnosticStatus(
        name=name, level=level, message=f"{state}: {reason}" if reason else state,
        values=[KeyValue(key=k, value=v) for k, v in values.items()],
    )  # fmt: skip


def debug_to_msg(debug: Debug, line: str, stamp: Any, frame_id: str) -> MarkerArray:
    """Return the grown obstacles, the ways weighed, the one taken, zones and people.

    Args:
        debug: What the method saw.
        line: The state and its reason, to stand above the robot.
        stamp: When.
        frame_id: The robot's frame.
    """
    shut = [w for w, t in zip(debug.candidates, debug.times, strict=True) if np.isfinite(t)]
    free = [w for w, t in zip(debug.candidates, debug.times, strict=True) if not np.isfinite(t)]
    taken = [debug.candidates[debug.chosen]] if debug.chosen >= 0 else []
    border = debug.grown[np.isfinite(debug.grown).all(axis=1)]
    zones = [_circle(0.0, 0.0, radius) for radius in debug.zones]
    drawn = [
        [_circle(x, y, radius), np.array([[x, y], [x + vx, y + vy]])]
        for x, y, vx, vy, radius in debug.people
    ]
    counts = drawn[debug.who] if debug.who >= 0 else []
    others = [way for k, ways in enumerate(drawn) if k != debug.who for way in ways]
    markers = [
        _marker(Marker.POINTS, "grown obstacles", border, _GROWN),
        _marker(Marker.LINE_LIST, "ways not free", _segments(shut), _SHUT),
        _marker(Marker.LINE_LIST, "ways free", _segments(free), _OPEN),
        _marker(Marker.LINE_LIST, "way taken", _segments(taken), _CHOSEN),
        _marker(Marker.LINE_LIST, "zones", _segments(zones), _ZONE),
        _marker(Marker.LINE_LIST, "people", _segments(others), _PERSON),
        _marker(Marker.LINE_LIST, "person who counts", _segments(counts), _COUNTS),
        _text(line),
    ]
    for marker in markers:
        marker.header.stamp, marker.header.frame_id = stamp, frame_id
    return MarkerArray(markers=markers)


def _text(line: str) -> Marker:
    marker = _marker(Marker.TEXT_VIEW_FACING, "state", np.zeros((0, 2)), _TEXT)
    marker.action, marker.text = Marker.ADD, line
    marker.pose.position.z, marker.scale.z = _ABOVE_M, _LETTER_M
    return marker


def _circle(x: float, y: float, radius: float) -> np.ndarray:
    """Return a circle as a line, shape (33, 2)."""
    turn = np.linspace(0.0, 2.0 * np.pi, 33)
    return np.column_stack((x + radius * np.cos(turn), y + radius * np.sin(turn)))


def _segments(ways: list[np.ndarray]) -> np.ndarray:
    """Return the ends of all legs of some ways, shape (2 L, 2)."""
    legs = [np.stack((way[:-1], way[1:]), axis=1).reshape(-1, 2) for way in ways]
    return np.concatenate(legs) if legs else np.zeros((0, 2))


def _marker(
    kind: int, name: str, points: np.ndarray, color: tuple[float, float, float, float]
) -> Marker:
    action = Marker.ADD if len(points) else Marker.DELETE
    marker = Marker(type=kind, ns=name, action=action)
    marker.scale.x = marker.scale.y = _LINE_M
    marker.pose.orientation.w = 1.0
    marker.color = ColorRGBA(r=color[0], g=color[1], b=color[2], a=color[3])
    marker.points = [Point(x=float(x), y=float(y), z=0.0) for x, y in points]
    return marker
