"""One robot's messages, brought to a moment."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.robot_inbox import ROBOTS, Classes, RobotInbox, Sight
from multi_localizer.team_node_config import TeamTimingConfig

S = 1_000_000_000
MS = 1_000_000
NOW = 100 * S
CLASSES = Classes(landmarks=frozenset({"goal"}), objects=frozenset({"ball"}))


def inbox(**values: object) -> RobotInbox:
    return RobotInbox("r1", TeamTimingConfig(**values), CLASSES, mount=SE2.identity())


def sight(box: RobotInbox, stamp_ns: int) -> Sight:
    found = box.sight_at(stamp_ns)
    assert isinstance(found, Sight), found
    return found


def drive(box: RobotInbox, speed: float, yaw_rate: float) -> None:
    """Odometry at 20 Hz over one second until now."""
    for k in range(21):
        t = k / 20
        box.take_odometry(NOW - S + round(t * S), SE2(speed * t, 0.0, yaw_rate * t), NOW)


def test_bearings_of_the_moment_come_as_they_were_taken() -> None:
    box = inbox()
    box.take_bearings(ROBOTS, NOW, np.array([0.1, -0.2]), NOW)
    box.take_bearings("goal", NOW, np.array([1.0]), NOW)
    box.take_bearings("ball", NOW, np.array([2.0]), NOW)
    found = sight(box, NOW)
    assert found.stamp_ns == NOW
    assert found.view.bearings == pytest.approx([0.1, -0.2])
    assert found.view.landmark_bearings["goal"] == pytest.approx([1.0])
    assert found.view.object_bearings["ball"] == pytest.approx([2.0])
    assert found.view.rough is None


def test_without_odometry_only_what_is_near_in_time_counts() -> None:
    box = inbox(max_skew_s=0.1)
    box.take_bearings(ROBOTS, NOW, np.array([0.1]), NOW)
    assert sight(box, NOW + 99 * MS).view.bearings == pytest.approx([0.1])
    assert box.sight_at(NOW + 150 * MS) == "its nearest bearings were taken 0.15 s before"
    assert box.sight_at(NOW - 150 * MS) == "its nearest bearings were taken 0.15 s after"


def test_with_odometry_bearings_turn_with_the_robot() -> None:
    box = inbox(max_skew_s=0.1, carry_s=0.5)
    drive(box, 0.0, 0.5)
    box.take_bearings(ROBOTS, NOW - 400 * MS, np.array([0.3, -3.1]), NOW)
    found = sight(box, NOW)
    assert found.view.bearings == pytest.approx([0.1, -3.3 + 2.0 * math.pi])
    assert isinstance(box.sight_at(NOW + 200 * MS), str)  # carry_s is over


def test_odometry_tells_of_no_motion_far_beyond_its_newest() -> None:
    box = inbox(max_skew_s=0.1)
    drive(box, 1.0, 0.0)
    within = box.motion(NOW - 500 * MS, NOW + 50 * MS)
    assert within is not None and within.x == pytest.approx(0.55)
    assert box.motion(NOW - 500 * MS, NOW + 150 * MS) is None
    assert box.motion(NOW - 2 * S, NOW) is None


def test_its_own_pose_is_moved_along_and_to_the_camera() -> None:
    box = inbox(odometry_error=0.1)
    box.mount = SE2(0.2, 0.0, math.pi / 2)
    drive(box, 1.0, 0.0)
    box.take_bearings(ROBOTS, NOW, np.array([0.0]), NOW)
    box.take_pose(NOW - 500 * MS, PoseEstimate(SE2(3.0, 1.0, 0.0), 0.01 * np.eye(3)), NOW)
    rough = sight(box, NOW).view.rough
    assert rough is not None
    assert rough.pose.as_array() == pytest.approx([3.7, 1.0, math.pi / 2])
    assert rough.cov[0, 0] == pytest.approx(0.01 + 0.05**2)


def test_a_pose_without_odometry_grows_uncertain_and_then_too_old() -> None:
    box = inbox(unknown_speed_m_s=0.5, pose_max_age_s=1.0)
    box.take_bearings(ROBOTS, NOW, np.array([0.0]), NOW)
    box.take_pose(NOW - 800 * MS, PoseEstimate(SE2(3.0, 1.0, 0.0), 0.01 * np.eye(3)), NOW)
    rough = sight(box, NOW).view.rough
    assert rough is not None
    assert rough.cov[0, 0] == pytest.approx(0.01 + 0.4**2)
    box.take_bearings(ROBOTS, NOW + 300 * MS, np.array([0.0]), NOW)
    assert sight(box, NOW + 300 * MS).view.rough is None


def test_bearings_of_nan_are_left_out_and_counted() -> None:
    box = inbox()
    box.take_bearings(ROBOTS, NOW, np.array([math.nan, 0.4, math.inf]), NOW)
    assert sight(box, NOW).view.bearings == pytest.approx([0.4])
    assert box.counts["void bearings"] == 2


def test_stamps_of_zero_and_far_ahead_are_refused_and_counted() -> None:
    box = inbox()
    assert not box.take_bearings(ROBOTS, 0, np.array([0.1]), NOW)
    assert not box.take_bearings(ROBOTS, NOW + 2 * S, np.array([0.1]), NOW)
    assert (box.counts["unstamped"], box.counts["ahead"]) == (1, 1)
    assert box.sight_at(NOW) == "no bearings"


@pytest.mark.parametrize("corrects", [True, False])
def test_a_clock_known_from_both_sides_is_set_right(corrects: bool) -> None:
    box = inbox(correct_clocks=corrects)
    box.clock.take_note(NOW + 3 * S, NOW - 20 * MS, NOW)  # 3.01 s ahead, within 10 ms
    came = box.take_bearings(ROBOTS, NOW + 3 * S + 10 * MS, np.array([0.1]), NOW)
    assert came is corrects
    if corrects:
        assert sight(box, NOW).stamp_ns == NOW


def test_a_camera_whose_place_is_unknown_says_so() -> None:
    box = RobotInbox("r1", TeamTimingConfig(), CLASSES)
    box.take_bearings(ROBOTS, NOW, np.array([0.1]), NOW)
    assert box.sight_at(NOW) == "where its camera sits is not known"


def test_after_a_clear_nothing_is_left() -> None:
    box = inbox()
    drive(box, 1.0, 0.0)
    box.take_bearings(ROBOTS, NOW, np.array([0.1]), NOW)
    box.clear()
    assert box.sight_at(NOW) == "no bearings" and box.motion(NOW - S, NOW) is None


def test_stamps_from_before_a_clock_was_known_are_not_taken_for_others() -> None:
    """Its clock is 0.7 s ahead, which is known only after a second."""
    box = inbox(max_skew_s=0.1)
    for k in range(10):
        at = NOW + k * 100 * MS
        box.take_odometry(at + 700 * MS, SE2(0.1 * k, 0.0, 0.0), at)
        box.take_bearings(ROBOTS, at + 700 * MS, np.array([0.1 * k]), at)
    at = NOW + S
    box.clock.take_note(at + 700 * MS, at - 20 * MS, at)  # 0.71 s ahead, within 10 ms
    box.take_bearings(ROBOTS, at + 700 * MS, np.array([1.0]), at)
    box.take_odometry(at + 700 * MS, SE2(1.0, 0.0, 0.0), at)
    found = sight(box, at - 10 * MS)
    assert found.stamp_ns == at - 10 * MS and found.view.bearings == pytest.approx([1.0])
    assert isinstance(box.sight_at(NOW + 500 * MS), str)
    assert box.motion(NOW + 500 * MS, at) is None


def test_a_clock_known_better_and_better_moves_old_and_new_alike() -> None:
    box = inbox(max_skew_s=0.1)
    for k in range(20):
        at = NOW + k * 100 * MS
        way = 40 - k
        offset = 500 * MS + (way // 2 if k % 2 else -way // 2) * MS  # within its error
        box.clock.take_note(at + offset - way // 2 * MS, at - way * MS, at)
        box.take_odometry(at + 500 * MS, SE2(0.1 * k, 0.0, 0.0), at)
    motion = box.motion(NOW + 500 * MS, NOW + 1500 * MS)
    assert motion is not None and motion.x == pytest.approx(1.0)


def test_odometry_tells_nothing_of_a_gap() -> None:
    box = inbox(carry_s=0.5)
    drive(box, 1.0, 0.0)
    box.take_odometry(NOW + 2 * S, SE2(9.0, 0.0, 0.0), NOW + 2 * S)
    assert box.motion(NOW - S, NOW + S) is None
    across = box.motion(NOW, NOW + 2 * S)
    assert across is not None and across.x == pytest.approx(8.0)


def test_a_clock_set_back_takes_all_it_sent_before_with_it() -> None:
    box = inbox()
    drive(box, 1.0, 0.0)
    for k in range(11):
        box.take_bearings(ROBOTS, NOW + k * 50 * MS, np.array([0.1]), NOW + S)
    for k in range(10):
        box.take_bearings(ROBOTS, NOW - 2 * S + k * 50 * MS, np.array([0.2]), NOW + S)
    assert box.newest_ns == NOW - 2 * S + 450 * MS
    assert box.motion(NOW - S, NOW) is None and box.counts["begun anew"] == 1
