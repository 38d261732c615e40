"""What counts as a jump of somebody else's pose."""

import math

import pytest

from floornav_common.se2 import SE2
from grid_mapper.pose_jumps import PoseJumps

S = 1_000_000_000


def test_driving_by_odometry_is_no_jump_and_a_correction_is_as_far_as_it_is():
    jumps = PoseJumps()
    assert jumps.jump(0, SE2(1.0, 0.0, math.pi / 2.0), SE2(0.0, 0.0, 0.0)) == 0.0
    # 2 m ahead by odometry is 2 m along y in the map
    assert jumps.jump(S, SE2(1.0, 2.0, math.pi / 2.0), SE2(2.0, 0.0, 0.0)) == pytest.approx(0.0)
    corrected = SE2(1.3, 3.0, math.pi / 2.0)
    assert jumps.jump(2 * S, corrected, SE2(3.0, 0.0, 0.0)) == pytest.approx(0.3)
    assert jumps.jump(3 * S, corrected, SE2(3.0, 0.0, 0.0)) == pytest.approx(0.0)


def test_without_odometry_every_motion_between_two_poses_counts():
    jumps = PoseJumps()
    jumps.jump(0, SE2.identity(), None)
    assert jumps.jump(S, SE2(0.4, 0.3, 0.0), None) == pytest.approx(0.5)
    assert jumps.jump(S // 2, SE2(9.0, 0.0, 0.0), None) == 0.0  # older: says nothing
    assert jumps.jump(2 * S, SE2(0.4, 0.3, 0.0), None) == pytest.approx(0.0)


def test_a_reading_that_comes_late_is_compared_by_odometry_and_is_not_the_new_last():
    jumps = PoseJumps()
    jumps.jump(S, SE2(1.0, 0.0, 0.0), SE2(1.0, 0.0, 0.0))
    assert jumps.jump(0, SE2(0.0, 0.0, 0.0), SE2(0.0, 0.0, 0.0)) == pytest.approx(0.0)
    assert jumps.jump(0, SE2(5.0, 0.0, 0.0), SE2(0.0, 0.0, 0.0)) == pytest.approx(5.0)
    assert jumps.jump(2 * S, SE2(2.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0)) == pytest.approx(0.0)


def test_after_a_restart_the_first_pose_is_no_jump():
    jumps = PoseJumps()
    jumps.jump(5 * S, SE2.identity(), None)
    jumps.clear()
    assert jumps.jump(0, SE2(9.0, 9.0, 0.0), None) == 0.0
