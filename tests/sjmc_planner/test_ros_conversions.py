"""What a planner saw, as markers."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("visualization_msgs", reason="no ROS messages")

from builtin_interfaces.msg import Time
from visualization_msgs.msg import Marker

from sjmc_planner.planning import Debug
from sjmc_planner.ros_conversions import debug_to_msg

PEOPLE = np.array([[1.0, 0.0, 0.0, -0.5, 0.25], [2.0, 1.0, 0.0, 0.0, 0.2]])
WAYS = [np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.0], [0.0, 2.0]])]
CIRCLE = 64  # ends of a circle's 32 legs; a walk has two


def markers(who: int, line: str = "driving") -> dict[str, Marker]:
    debug = Debug(
        np.array([[0.3, 0.3], [np.nan, np.nan]]), WAYS, np.array([1.0, np.inf]), 1, (1.1, 4.2),
        PEOPLE, who,
    )  # fmt: skip
    msg = debug_to_msg(debug, line, Time(sec=7), "r1/base_link")
    assert {m.header.frame_id for m in msg.markers} == {"r1/base_link"}
    assert {m.header.stamp.sec for m in msg.markers} == {7}
    return {marker.ns: marker for marker in msg.markers}


def ends(marker: Marker) -> np.ndarray:
    return np.array([(p.x, p.y) for p in marker.points])


def test_the_state_and_its_reason_stand_above_the_robot() -> None:
    text = markers(-1, "waiting: for a person, 2.1 s")["state"]
    assert text.type == Marker.TEXT_VIEW_FACING and text.action == Marker.ADD
    assert text.text == "waiting: for a person, 2.1 s"
    place = text.pose.position
    assert (place.x, place.y) == (0.0, 0.0) and place.z > 0.5
    assert text.scale.z > 0.05 and text.color.a > 0.0 and not text.points


def test_who_counts_has_another_color_than_the_others() -> None:
    shown = markers(0)
    counts, others = shown["person who counts"], shown["people"]
    assert counts.action == others.action == Marker.ADD and counts.color != others.color
    assert len(counts.points) == len(others.points) == CIRCLE + 2
    assert np.hypot(*(ends(counts)[:CIRCLE] - PEOPLE[0, :2]).T) == pytest.approx(0.25)
    assert ends(counts)[CIRCLE:] == pytest.approx(np.array([[1.0, 0.0], [1.0, -0.5]]))
    assert np.hypot(*(ends(others)[:CIRCLE] - PEOPLE[1, :2]).T) == pytest.approx(0.2)


def test_where_nobody_counts_the_last_one_is_taken_away() -> None:
    shown = markers(-1)
    assert shown["person who counts"].action == Marker.DELETE
    assert len(shown["people"].points) == 2 * (CIRCLE + 2)


def test_free_ways_and_shut_ones_are_apart_and_the_one_taken_too() -> None:
    shown = markers(-1)
    assert ends(shown["ways not free"]) == pytest.approx(WAYS[0])
    assert ends(shown["ways free"]) == pytest.approx(WAYS[1])
    assert ends(shown["way taken"]) == pytest.approx(WAYS[1])
    assert len(shown["grown obstacles"].points) == 1
