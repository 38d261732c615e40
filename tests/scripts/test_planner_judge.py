"""What a drive among people is judged by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from experiments.planner_contacts import gap_to, is_by_robot
from experiments.planner_judge import Drive, count_turns

OUTLINE = np.array([[0.2, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.2, -0.3]])


def drive_of(speeds: list[float], yaws: list[float]) -> Drive:
    num = len(speeds)
    poses = np.column_stack((0.1 * np.cumsum(speeds), np.zeros(num), yaws))
    return Drive(
        is_reached=True, time_s=0.1 * num, times=0.1 * np.arange(1, num + 1), poses=poses,
        speeds=np.array(speeds), off_goal=np.array(yaws), gaps=np.full(num, np.inf), contacts=(),
        states=(), people={},
    )  # fmt: skip


def test_the_gap_to_an_outline_by_hand() -> None:
    points = np.array([[1.2, 0.0], [0.5, 0.7], [0.0, 0.0], [-0.5, -1.3]])
    assert gap_to(OUTLINE, points) == pytest.approx([1.0, 0.5, -0.2, 1.0])
    assert gap_to(OUTLINE[::-1], points) == pytest.approx([1.0, 0.5, -0.2, 1.0])


def test_turns_are_counted_one_way_at_a_time() -> None:
    least = math.radians(15.0)
    there_and_back = np.radians([0, 5, 10, 20, 30, 20, 10, 0])
    assert count_turns(there_and_back, least) == 2
    assert count_turns(np.radians([0, 10, 0, -10, 4, -10, 0]), least) == 1
    assert count_turns(np.radians([0, 10, 0, -4, 9, 0]), least) == 0
    assert count_turns(np.radians([0, 20, 40, 80]), least) == 1
    assert count_turns(-there_and_back, least) == 2


def test_who_stands_did_not_do_it_and_who_drives_into_somebody_did() -> None:
    ahead, behind = np.array([0.4, 0.0]), np.array([-0.7, 0.0])
    assert not is_by_robot(OUTLINE, ahead, (0.04, 0.0))
    assert is_by_robot(OUTLINE, ahead, (0.5, 0.0))
    assert not is_by_robot(OUTLINE, behind, (0.5, 0.0))
    assert is_by_robot(OUTLINE, behind, (-0.5, 0.0))
    assert is_by_robot(OUTLINE, ahead, (-0.5, 0.0))  # by the letter, though it backs away


def test_turning_into_somebody_beside_is_the_robots_doing() -> None:
    """0.6 rad/s swing a corner 0.4 m behind the base at 0.24 m/s to the right."""
    right_rear = np.array([OUTLINE[:, 0].min() + 0.05, OUTLINE[:, 1].min() - 0.15])
    assert is_by_robot(OUTLINE, right_rear, (0.0, 0.0), 0.6)
    assert not is_by_robot(OUTLINE, right_rear, (0.0, 0.0), -0.6)
    assert not is_by_robot(OUTLINE, right_rear, (0.0, 0.0), 0.05)


def test_rest_counts_from_when_it_set_out() -> None:
    drive = drive_of([0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5, 0.0], [0.0] * 8)
    assert drive.not_moving_s == pytest.approx(0.4)
    assert drive.longest_stop_s == pytest.approx(0.3)
    assert drive.path_m == pytest.approx(0.1)


def test_the_angle_to_the_goal_is_the_largest_either_way() -> None:
    drive = drive_of([0.5, 0.5, 0.5], [0.1, -0.4, 0.2])
    assert drive.most_off_rad == pytest.approx(0.4)
    assert drive.turned_rad == pytest.approx(1.1)
    assert drive.min_gap_m == math.inf and not drive.has_touched
