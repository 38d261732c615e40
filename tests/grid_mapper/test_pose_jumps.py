"""What counts as a jump of somebody else's pose."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from grid_mapper.pose_jumps import MAX_SPEED, PoseJumps

S = 1_000_000_000
LIMIT_M = 0.3


def spread(correction: SE2, num: int, period_ns: int = S // 10, jumps=None):
    """Return what is told of a straight drive that a correction comes into over `num` inputs.

    Ten inputs before, then `num` with a share of the correction each, as TF interpolates
    map->odom, then twenty with all of it.
    """
    jumps = jumps or PoseJumps()
    told = []
    for k in range(10 + num + 20):
        share = min(max((k - 9) / num, 0.0), 1.0)
        odom = SE2(0.05 * k, 0.0, 0.0)
        told.append(
            jumps.jump(k * period_ns, SE2.identity().interpolate(correction, share) @ odom, odom)
        )
    return told


def test_driving_by_odometry_is_no_jump_and_a_correction_is_as_far_as_it_is():
    jumps = PoseJumps()
    assert jumps.jump(0, SE2(1.0, 0.0, math.pi / 2.0), SE2(0.0, 0.0, 0.0)).distance == 0.0
    # 2 m ahead by odometry is 2 m along y in the map
    told = jumps.jump(S, SE2(1.0, 2.0, math.pi / 2.0), SE2(2.0, 0.0, 0.0))
    assert (told.distance, told.turn) == pytest.approx((0.0, 0.0))
    corrected = SE2(1.3, 3.0, math.pi / 2.0)
    assert jumps.jump(2 * S, corrected, SE2(3.0, 0.0, 0.0)).distance == pytest.approx(0.3)
    assert jumps.jump(3 * S, corrected, SE2(3.0, 0.0, 0.0)).distance == pytest.approx(0.0)


@pytest.mark.parametrize("num", [1, 8])
def test_a_jump_of_a_meter_is_seen_whole_over_however_many_inputs_it_is_spread(num):
    told = [each.distance for each in spread(SE2(0.0, 1.0, 0.0), num)]
    assert max(told[:10]) == pytest.approx(0.0) and max(told) == pytest.approx(1.0)
    # while it is on its way, and until what lies a second back is after it too
    is_jumping = [each > LIMIT_M for each in told]
    assert all(is_jumping[10 + math.floor(LIMIT_M * num) : 10 + num])
    assert not any(is_jumping[10 + num + 10 :])


def test_a_turn_alone_is_a_jump_too():
    told = spread(SE2(0.0, 0.0, 0.5), 8)
    assert max(each.turn for each in told) == pytest.approx(0.5)
    assert told[-1].turn == pytest.approx(0.0)
    back = PoseJumps()
    back.jump(0, SE2(0.0, 0.0, 3.0), SE2.identity())
    assert back.jump(S // 10, SE2(0.0, 0.0, -3.0), SE2.identity()).turn == pytest.approx(
        2.0 * math.pi - 6.0
    )


def test_a_slow_correction_is_no_jump():
    """A meter in 30 s, as a localizer corrects the drift of odometry."""
    told = spread(SE2(0.0, 1.0, 0.0), 300)
    assert max(each.distance for each in told) < 0.04


@given(
    x=st.floats(-5, 5), yaw=st.floats(-3, 3), odom_yaw=st.floats(-3, 3), step=st.floats(-0.2, 0.2)
)
def test_where_map_and_odometry_begin_and_how_the_robot_drives_makes_no_jump(
    x, yaw, odom_yaw, step
):
    jumps, T_map_odom, odom = PoseJumps(), SE2(x, -1.0, yaw), SE2(3.0, x, odom_yaw)
    for k in range(15):
        odom = odom @ SE2(step, 0.0, 2.0 * step)
        told = jumps.jump(k * S // 10, T_map_odom @ odom, odom)
        assert told.distance < 1e-9 and told.turn < 1e-9


def test_without_odometry_what_a_robot_may_drive_in_the_time_is_no_jump():
    jumps = PoseJumps()
    jumps.jump(0, SE2.identity(), None)
    assert jumps.jump(S // 2, SE2(0.5 * MAX_SPEED, 0.0, 0.0), None).distance == pytest.approx(0.0)
    told = jumps.jump(S, SE2(3.0 * MAX_SPEED, 0.0, 0.0), None)
    assert told.distance == pytest.approx(2.0 * MAX_SPEED)
    for k in range(2, 5):
        told = jumps.jump(k * S, SE2(3.0 * MAX_SPEED, 0.0, 0.0), None)
    assert told.distance == 0.0


def test_inputs_farther_apart_than_the_window_are_compared_with_the_one_before():
    jumps = PoseJumps()
    for k in range(3):
        told = jumps.jump(5 * k * S, SE2(float(k == 2), 0.0, 0.0), SE2.identity())
    assert told.distance == pytest.approx(1.0)
    assert jumps.jump(15 * S, SE2(1.0, 0.0, 0.0), SE2.identity()).distance == pytest.approx(0.0)


def test_a_reading_that_comes_late_is_compared_by_odometry_and_is_not_the_new_last():
    jumps = PoseJumps()
    jumps.jump(S, SE2(1.0, 0.0, 0.0), SE2(1.0, 0.0, 0.0))
    at_start = SE2.identity()
    assert jumps.jump(0, at_start, at_start).distance == pytest.approx(0.0)
    assert jumps.jump(0, SE2(5.0, 0.0, 0.0), at_start).distance == pytest.approx(5.0)
    two = SE2(2.0, 0.0, 0.0)
    assert jumps.jump(2 * S, two, two).distance == pytest.approx(0.0)


def test_after_a_restart_the_first_pose_is_no_jump():
    jumps = PoseJumps()
    jumps.jump(5 * S, SE2.identity(), None)
    jumps.clear()
    told = jumps.jump(0, SE2(9.0, 9.0, 0.0), None)
    assert (told.distance, told.turn) == (0.0, 0.0)
