"""A team for RViz: arrows, names, ellipses of two deviations, lines of sight, other things."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from floornav_common.ros.messages import se2_to_pose
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_answers import TeamAnswer

_ROBOT = ColorRGBA(r=0.1, g=0.5, b=0.9, a=1.0)
_OWN = ColorRGBA(r=0.1, g=0.8, b=0.3, a=1.0)
_DOUBT = ColorRGBA(r=0.1, g=0.5, b=0.9, a=0.25)
_SIGHT = ColorRGBA(r=0.9, g=0.7, b=0.1, a=0.6)
_OBJECT = ColorRGBA(r=0.9, g=0.4, b=0.1, a=0.9)
_ARROW_M, _FLAT_M, _TEXT_M, _LINE_M = 0.4, 0.01, 0.25, 0.01
_DEVIATIONS = 2.0


def team_markers(answer: TeamAnswer, own: str, stamp: Any, frame_id: str) -> MarkerArray:
    """Return what to draw; the first marker wipes out what was drawn before."""
    markers = [_marker("", 0, Marker.ARROW, SE2.identity(), _ROBOT, (0.0, 0.0, 0.0))]
    markers[0].action = Marker.DELETEALL
    for number, (name, estimate) in enumerate(answer.bases.items()):
        markers += _robot(number, name, estimate, _OWN if name == own else _ROBOT)
    markers.append(_sights(answer))
    for number, thing in enumerate(answer.solution.objects):
        place = SE2(float(thing.position[0]), float(thing.position[1]), 0.0)
        markers.append(_ellipse("objects", number, place, thing.cov, _OBJECT))
        markers.append(_text("object names", number, place, thing.kind, _OBJECT))
    for marker in markers:
        marker.header.stamp, marker.header.frame_id = stamp, frame_id
    return MarkerArray(markers=markers)


def _robot(number: int, name: str, estimate: PoseEstimate, color: ColorRGBA) -> list[Marker]:
    size = (_ARROW_M, 0.2 * _ARROW_M, 0.2 * _ARROW_M)
    return [
        _marker("robots", number, Marker.ARROW, estimate.pose, color, size),
        _text("names", number, estimate.pose, name, color),
        _ellipse("deviations", number, estimate.pose, estimate.cov[:2, :2], _DOUBT),
    ]


def _sights(answer: TeamAnswer) -> Marker:
    """Lines from robots to those they were found to have seen."""
    marker = _marker("sights", 0, Marker.LINE_LIST, SE2.identity(), _SIGHT, (_LINE_M, 0.0, 0.0))
    names, bases = answer.solution.names, answer.bases
    for name, identities in answer.solution.identities.items():
        for who in identities:
            if name in bases and who >= 0 and names[who] in bases:
                marker.points += [_point(bases[name].pose), _point(bases[names[who]].pose)]
    return marker


def _ellipse(ns: str, number: int, at: SE2, cov: np.ndarray, color: ColorRGBA) -> Marker:
    values, axes = np.linalg.eigh(cov)
    long, short = 2.0 * _DEVIATIONS * np.sqrt(np.maximum(values[::-1], 0.0))
    pose = SE2(at.x, at.y, math.atan2(axes[1, 1], axes[0, 1]))
    return _marker(ns, number, Marker.CYLINDER, pose, color, (float(long), float(short), _FLAT_M))


def _text(ns: str, number: int, at: SE2, text: str, color: ColorRGBA) -> Marker:
    marker = _marker(ns, number, Marker.TEXT_VIEW_FACING, at, color, (0.0, 0.0, _TEXT_M))
    marker.text, marker.pose.position.z = text, 2.0 * _TEXT_M
    return marker


def _marker(
    ns: str, number: int, kind: int, pose: SE2, color: ColorRGBA, size: tuple[float, ...]
) -> Marker:
    marker = Marker(ns=ns, id=number, type=kind, pose=se2_to_pose(pose), color=color)
    marker.scale.x, marker.scale.y, marker.scale.z = size
    return marker


def _point(pose: SE2) -> Point:
    return Point(x=pose.x, y=pose.y)
