"""Poses of views that confirm each other, or do not."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkTrackConfig
from multi_localizer.landmark_tracker import LandmarkTracker
from multi_localizer.pose_estimate import PoseEstimate, difference

PERIOD_NS = 100_000_000
STEP, ODOM = SE2(0.05, 0.0, 0.1), SE2(5.0, -3.0, 1.0)


def estimate(pose):
    return PoseEstimate(pose, np.diag([0.02, 0.02, 0.01]) ** 2)


class Drive:
    """A robot that drives a circle; its tracker is told the truth, or something else."""

    def __init__(self, has_odometry=True, **values):
        self.tracker = LandmarkTracker(LandmarkTrackConfig(**values))
        self.pose, self.odom = SE2(1.0, -0.5, 0.3), ODOM if has_odometry else None
        self.stamp_ns = 0

    def see(self, off=None, is_seen=True):
        self.stamp_ns += PERIOD_NS
        self.pose = self.pose @ STEP
        self.odom = self.odom @ STEP if self.odom is not None else None
        seen = estimate(self.pose if off is None else off @ self.pose) if is_seen else None
        return self.tracker.update(self.stamp_ns, seen, self.odom)


@pytest.mark.parametrize("has_odometry", [True, False])
def test_the_third_view_in_a_row_confirms_a_pose_that_moves_as_the_robot_does(has_odometry):
    drive = Drive(has_odometry)
    said = [drive.see() for _ in range(5)]
    assert ["of 3" in words for words in said] == [True, True, False, False, False]
    assert said[2:] == [""] * 3


def test_views_that_disagree_confirm_nothing():
    drive, rng = Drive(), np.random.default_rng(0)
    for _ in range(30):
        x, y, yaw = rng.uniform(-2.0, 2.0, 3)
        assert drive.see(SE2(float(x), float(y), float(yaw)))


def test_a_view_without_a_pose_begins_the_count_anew():
    drive = Drive()
    said = [drive.see(is_seen=k != 2) for k in range(6)]
    assert [bool(words) for words in said] == [True, True, False, True, True, False]


def test_one_wrong_view_is_not_given_and_the_next_right_one_is():
    drive = Drive()
    for _ in range(4):
        drive.see()
    assert "does not follow" in drive.see(SE2(0.5, 0.0, 0.0))
    assert drive.see() == ""


def test_carried_away_is_believed_after_a_while_not_at_once():
    drive, off = Drive(), SE2(-1.0, 1.0, 2.0)
    for _ in range(4):
        drive.see()
    said = [drive.see(off) for _ in range(8)]
    assert [bool(words) for words in said] == [True] * 4 + [False] * 4


def test_the_expected_pose_is_the_last_one_moved_on():
    drive = Drive()
    assert drive.tracker.expected(PERIOD_NS, ODOM) is None
    for _ in range(4):
        drive.see()
    expected = drive.tracker.expected(drive.stamp_ns + PERIOD_NS, drive.odom @ STEP)
    assert np.abs(difference(expected.pose, drive.pose @ STEP)).max() < 1e-9


def test_unseen_for_some_time_the_last_pose_tells_no_poses_apart_before_it_is_seen_again():
    drive = Drive(lost_after_s=0.5)
    for _ in range(4):
        drive.see()
    for is_told in (True, True, True, True, True, False):
        now = drive.stamp_ns + PERIOD_NS
        assert (drive.tracker.expected(now, drive.odom) is not None) is is_told
        drive.see(is_seen=False)
    drive.see()
    assert drive.tracker.expected(drive.stamp_ns + PERIOD_NS, drive.odom) is not None


def test_a_pose_unseen_for_long_and_stamps_set_back_are_begun_anew():
    drive = Drive(forget_s=1.0)
    for _ in range(4):
        drive.see()
    for _ in range(11):
        drive.see(is_seen=False)
    assert "1 of 3" in drive.see()
    for _ in range(3):
        drive.see()
    drive.stamp_ns = 0
    assert "1 of 3" in drive.see()
