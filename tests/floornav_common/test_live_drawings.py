"""ROS messages as the live view's page draws them; fields are only read, so no ROS is needed."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace as Msg
from typing import Any

import cv2
import numpy as np
import pytest

from floornav_common.live_view.encoding import split_message
from floornav_common.ros import live_drawings as draw
from floornav_common.se2 import SE2

HERE = SE2.identity()
QUARTER = math.pi / 2.0
TOL_M = 1e-6


def point(x: float, y: float) -> Msg:
    return Msg(x=x, y=y, z=0.0)


def pose(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Msg:
    turn = Msg(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return Msg(position=point(x, y), orientation=turn)


def marker(kind: int, points: list[tuple[float, float]], **changes: Any) -> Msg:
    values = {
        "header": Msg(frame_id="base_link"), "ns": "zones", "type": kind, "action": 0,
        "pose": pose(), "points": [point(*p) for p in points],
        "color": Msg(r=1.0, g=0.0, b=0.0, a=1.0),
    }  # fmt: skip
    return Msg(**(values | changes))


def floats(payload: bytes) -> np.ndarray:
    return np.frombuffer(payload, "<f4").reshape(-1, 2)


def test_a_map_lies_where_its_frame_does() -> None:
    info = Msg(width=2, height=1, resolution=0.5, origin=pose(1.0, 0.0))
    msg = Msg(info=info, data=np.array([0, 100], np.int8))
    head, png = split_message(draw.map_message("glass", msg, SE2(0.0, 3.0, QUARTER)))
    assert (head["kind"], head["width"], head["height"], head["resolution"]) == ("glass", 2, 1, 0.5)
    assert head["origin"] == pytest.approx({"x": 0.0, "y": 4.0, "yaw": QUARTER}, abs=1e-4)
    assert cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED).tolist() == [[1, 101]]


def test_a_scan_is_its_hits_in_the_map_frame() -> None:
    ranges = np.array([2.0, math.inf, 1.0, math.nan, 9.0], np.float32)
    msg = Msg(ranges=ranges, angle_min=0.0, angle_increment=QUARTER / 2, range_min=0.1,
              range_max=5.0, time_increment=0.0)  # fmt: skip
    head, payload = split_message(draw.scan_message(msg, SE2(1.0, 1.0, QUARTER)))
    assert np.allclose(floats(payload), [[1.0, 3.0], [0.0, 1.0]], atol=TOL_M)
    assert head["sensor"]["x"] == 1.0


def test_a_sonar_without_an_echo_is_free_as_far_as_it_reaches() -> None:
    def reading(value: float) -> Msg:
        return Msg(range=value, field_of_view=0.3, min_range=0.2, max_range=4.0)

    cones = [(reading(r), HERE) for r in (1.5, 4.0, math.inf, math.nan)]
    found = json.loads(draw.sonar_message(cones))["cones"]
    assert [(c["reach"], c["echo"]) for c in found] == [(1.5, True)] + 3 * [(4.0, False)]


def test_a_way_is_its_places_in_the_map_frame() -> None:
    poses = [Msg(pose=pose(x, 0.0)) for x in (0.0, 1.0, 2.0)]
    _, payload = split_message(draw.way_message("path", Msg(poses=poses), SE2(0.0, 5.0, 0.0)))
    assert floats(payload).tolist() == [[0.0, 5.0], [1.0, 5.0], [2.0, 5.0]]


def test_an_empty_way_has_no_places() -> None:
    assert split_message(draw.way_message("path", Msg(poses=[]), HERE))[1] == b""


def test_markers_are_lines_and_points_in_the_map_frame() -> None:
    strip = marker(4, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], ns="strip")
    pairs = marker(5, [(0.0, 0.0), (2.0, 0.0)], ns="pairs", pose=pose(0.0, 1.0))
    dots = marker(8, [(3.0, 3.0)], ns="dots")
    head, payload = split_message(
        draw.markers_message(Msg(markers=[strip, pairs, dots]), {"base_link": SE2(10.0, 0.0, 0.0)})
    )
    assert [(g["name"], g["points"], g["num"]) for g in head["groups"]] == [
        ("strip", False, 32), ("pairs", False, 16), ("dots", True, 8),
    ]  # fmt: skip
    assert floats(payload).tolist() == [
        [10.0, 0.0], [11.0, 0.0], [11.0, 0.0], [11.0, 1.0],
        [10.0, 1.0], [12.0, 1.0],
        [13.0, 3.0],
    ]  # fmt: skip


def test_markers_that_are_deleted_unknown_or_nowhere_are_left_out() -> None:
    there = [(0.0, 0.0), (1.0, 0.0)]
    gone, sphere = marker(5, there, action=2), marker(2, there)
    nowhere = marker(5, there, header=Msg(frame_id="nowhere"))
    head, payload = split_message(
        draw.markers_message(Msg(markers=[gone, sphere, nowhere]), {"base_link": HERE})
    )
    assert head["groups"] == []
    assert payload == b""


def test_a_picture_comes_as_a_jpeg_of_its_colors() -> None:
    pixels = np.full((20, 40, 3), (200, 30, 30), np.uint8)  # red, as rgb8 has it
    msg = Msg(encoding="rgb8", is_bigendian=0, height=20, width=40, step=120, data=pixels.ravel())
    _, jpeg = split_message(draw.image_message(msg, 480, 90))
    shown = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(shown.astype(int) - (30, 30, 200)).max() < 12


def test_a_picture_of_an_unknown_encoding_is_refused() -> None:
    msg = Msg(encoding="16UC1", is_bigendian=0, height=1, width=1, step=2, data=np.zeros(2))
    with pytest.raises(ValueError, match="16UC1"):
        draw.image_message(msg, 480, 90)
