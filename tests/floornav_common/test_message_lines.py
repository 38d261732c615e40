from __future__ import annotations

import math
from types import SimpleNamespace as Bag
from typing import Any

import pytest

from floornav_common.message_lines import one_line


class Message:
    """Has fields as generated messages have."""

    def __init__(self, **fields: Any) -> None:
        self.__dict__ = fields

    def get_fields_and_field_types(self) -> dict[str, str]:
        return dict.fromkeys(self.__dict__, "")


def pose(x: float, y: float, yaw: float) -> Bag:
    q = Bag(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return Bag(position=Bag(x=x, y=y, z=0.0), orientation=q)


HEADER = Bag(stamp=Bag(sec=3, nanosec=250_000_000), frame_id="map")


def test_a_pose_with_covariance_by_hand():
    covariance = [0.0] * 36
    covariance[0], covariance[7], covariance[35] = 0.01, 0.0004, math.radians(2.0) ** 2
    msg = Bag(header=HEADER, pose=Bag(pose=pose(1.0, -2.5, math.pi / 2), covariance=covariance))
    assert one_line(msg) == (
        "3.250 s in 'map': x 1.000 y -2.500 m yaw 90.0 deg, deviations 0.100 0.020 m 2.00 deg"
    )


def test_a_covariance_that_is_none_is_said():
    msg = Bag(header=HEADER, pose=Bag(pose=pose(0, 0, 0), covariance=[math.nan] * 36))
    assert one_line(msg).endswith("no covariance")


def test_poses_are_counted_and_no_more_than_eight_listed():
    assert one_line(Bag(poses=[])) == "0 poses"
    line = one_line(Bag(poses=[pose(0, 0, 0)] * 9))
    assert line.startswith("9 poses: x 0.000") and line.endswith("...")


@pytest.mark.parametrize(
    ("msg", "line"),
    [
        (Message(), "(empty)"),
        (Message(data=True), "data True"),
        (Message(a=Message(b=0.5, c="x"), d=3), "a.b 0.5, a.c x, d 3"),
        (Message(ranges=[1.0, 2.0, 3.0, 4.0, 5.0]), "ranges [1, 2, 3, 4, ...] (5)"),
        (Message(all=[Message(b=1), Message(b=2)]), "all [b 1; b 2] (2)"),
    ],
)
def test_other_messages_are_names_and_values(msg, line):
    assert one_line(msg) == line


def test_no_line_is_longer_than_a_screen():
    assert len(one_line(Message(text="x" * 10_000))) == 240
