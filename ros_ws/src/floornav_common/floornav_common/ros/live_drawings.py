"""Messages as the live view's page draws them; fields are only read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floornav_common.live_view.encoding import (
    binary_message,
    color_text,
    cone_values,
    grid_png,
    lines_payload,
    picture_jpeg,
    points_payload,
    pose_values,
    text_message,
)
from floornav_common.ros.messages import (
    grid_from_msg,
    image_to_array,
    pose_to_se2,
    range_from_msg,
    scan_from_msg,
)
from floornav_common.se2 import SE2

_LINE_STRIP, _LINE_LIST, _POINTS = 4, 5, 8  # visualization_msgs/Marker
_ADD = 0
_MAX_POINTS = 20_000  # of one message: more is no drawing any more


def map_message(kind: str, msg: Any, T_map_frame: SE2) -> bytes:
    """Return a map or a layer of it: a picture, and where it lies.

    Raises:
        ValueError: If the message is no map.
    """
    grid = grid_from_msg(msg)
    height, width = grid.cells.shape
    return binary_message(
        kind, grid_png(grid.cells), width=width, height=height, resolution=grid.resolution,
        origin=pose_values(T_map_frame @ grid.origin),
    )  # fmt: skip


def scan_message(msg: Any, T_map_laser: SE2) -> bytes:
    """Return what a scan hit, in the map frame.

    Raises:
        ValueError: If the message is no scan.
    """
    points = T_map_laser @ scan_from_msg(msg).points()
    return binary_message("scan", points_payload(points), sensor=pose_values(T_map_laser))


def sonar_message(cones: Sequence[tuple[Any, SE2]]) -> str:
    """Return the newest cone of each sonar, in the robot's frame.

    Args:
        cones: sensor_msgs/Range and `T_base_sonar` of each.
    """
    found = []
    for msg, T_base_sonar in cones:
        reading = range_from_msg(msg)
        is_echo = reading.min_range <= reading.range < reading.max_range
        reach = reading.range if is_echo else reading.max_range
        found.append(cone_values(T_base_sonar, reading.field_of_view, reach, is_echo))
    return text_message("sonar", cones=[cone for cone in found if cone is not None])


def way_message(kind: str, msg: Any, T_map_frame: SE2) -> bytes:
    """Return the places of a Path in the map frame."""
    places = [(p.pose.position.x, p.pose.position.y) for p in msg.poses[-_MAX_POINTS:]]
    points = np.array(places, dtype=float).reshape(-1, 2)
    return binary_message(kind, points_payload(T_map_frame @ points))


def goal_message(msg: Any, T_map_frame: SE2) -> str:
    """Return a goal in the map frame.

    Raises:
        ValueError: If a number is not finite.
    """
    return text_message("goal", **pose_values(T_map_frame @ pose_to_se2(msg.pose)))


def markers_message(msg: Any, transforms: Mapping[str, SE2]) -> bytes:
    """Return points and lines of a MarkerArray in the map frame, grouped as they came.

    Other kinds of markers are left out; so are those of frames that `transforms` does not have.

    Args:
        msg: visualization_msgs/MarkerArray.
        transforms: `T_map_frame` by frame id.

    Raises:
        ValueError: If a marker's pose is none.
    """
    groups, payload = [], b""
    for marker in msg.markers:
        T_map_frame = transforms.get(marker.header.frame_id)
        is_drawn = marker.type in (_LINE_STRIP, _LINE_LIST, _POINTS)
        if marker.action != _ADD or not is_drawn or T_map_frame is None:
            continue
        places = np.array([(p.x, p.y) for p in marker.points[:_MAX_POINTS]]).reshape(-1, 2)
        points = T_map_frame @ pose_to_se2(marker.pose) @ places
        if marker.type == _LINE_STRIP:
            points = np.stack((points[:-1], points[1:]), axis=1).reshape(-1, 2)
        is_points = marker.type == _POINTS
        data = points_payload(points) if is_points else lines_payload(points)
        color = color_text((marker.color.r, marker.color.g, marker.color.b, marker.color.a))
        groups.append({"name": marker.ns, "points": is_points, "color": color, "num": len(data)})
        payload += data
    return binary_message("markers", payload, groups=groups)


def state_message(msg: Any) -> str:
    """Return the planner's DiagnosticStatus."""
    values = {value.key: value.value for value in msg.values}
    return text_message("planner", level=level_of(msg), message=msg.message, values=values)


def level_of(status: Any) -> int:
    """Return a DiagnosticStatus's level: 0 OK, 1 WARN, 2 ERROR, 3 STALE."""
    return int(status.level[0]) % 4 if isinstance(status.level, bytes) else int(status.level) % 4


def image_message(msg: Any, width: int, quality: int) -> bytes:
    """Return an Image as a JPEG.

    Raises:
        ValueError: If its encoding is none of ours.
    """
    encoding = "mono8" if msg.encoding == "mono8" else "bgr8"
    pixels = image_to_array(msg, encoding)
    return binary_message("image", picture_jpeg(pixels, width, quality))
