"""The pose between two scans, and when there is none."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from grid_mapper.pose_history import PoseHistory

S = 1_000_000_000


def history(*entries):
    made = PoseHistory()
    for stamp_s, pose in entries:
        made.add(round(stamp_s * S), pose)
    return made


def test_halfway_in_time_is_halfway_in_place_and_turn():
    made = history((1.0, SE2(0.0, 0.0, 0.0)), (2.0, SE2(1.0, 2.0, 0.4)))
    assert made.at(3 * S // 2, S) == SE2(0.5, 1.0, 0.2)
    assert made.newest_ns == 2 * S


def test_the_turn_goes_the_shorter_way_over_pi():
    made = history((0.0, SE2(0.0, 0.0, 3.0)), (1.0, SE2(0.0, 0.0, -3.0)))
    assert abs(made.at(S // 2, S).yaw) == pytest.approx(math.pi)


def test_the_stamp_of_a_pose_is_that_pose_whatever_the_gap():
    made = history((0.0, SE2(0.0, 0.0, 0.0)), (60.0, SE2(5.0, 0.0, 0.0)))
    assert made.at(60 * S, 1).x == 5.0 and made.at(0, 1).x == 0.0


def test_there_is_no_pose_before_the_first_beyond_the_newest_in_a_gap_or_across_a_break():
    made = history((1.0, SE2.identity()), (2.0, SE2(0.1, 0.0, 0.0)))
    assert PoseHistory().at(0, S) is None and PoseHistory().newest_ns is None
    assert made.at(S // 2, S) is None
    assert made.at(3 * S, S) is None
    assert made.at(3 * S // 2, S // 2) is None
    made.break_here()
    made.add(5 * S // 2, SE2(9.0, 0.0, 0.0))
    assert made.at(9 * S // 4, S) is None
    assert made.at(3 * S // 2, S).x == pytest.approx(0.05)


def test_a_stamp_that_goes_back_begins_anew():
    made = history((5.0, SE2.identity()), (6.0, SE2(1.0, 0.0, 0.0)), (1.0, SE2(2.0, 0.0, 0.0)))
    assert made.newest_ns == S and made.at(11 * S // 2, S) is None


def test_only_the_newest_poses_are_kept():
    made = PoseHistory(max_poses=3)
    for k in range(10):
        made.add(k * S, SE2(float(k), 0.0, 0.0))
    assert made.at(6 * S, S) is None and made.at(7 * S, S).x == 7.0


@given(share=st.floats(0.0, 1.0), x=st.floats(-5, 5), yaw=st.floats(-3, 3))
def test_world_and_robot_moved_together_give_the_moved_pose(share, x, yaw):
    a, b, T = SE2(0.3, -1.0, 0.5), SE2(0.7, -0.2, 1.1), SE2(x, 2.0, yaw)
    stamp_ns = round(share * S)
    plain = history((0.0, a), (1.0, b)).at(stamp_ns, S)
    moved = history((0.0, T @ a), (1.0, T @ b)).at(stamp_ns, S)
    off = (T @ plain).between(moved)
    assert off.distance < 1e-9 and abs(off.yaw) < 1e-9
