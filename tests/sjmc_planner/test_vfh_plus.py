"""VFH+ as a whole: what the four stages choose, and a drive by it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.planning import BLOCKED, DRIVING, STILL, Goal, Obstacles, RobotState, Velocity
from sjmc_planner.vfh_plus import VfhPlus

ROBOT = RobotConfig(
    drive="omni", radius_m=0.25, margin_m=0.025, speed_m_s=0.8, accel_m_s2=1.0, yaw_rate_rad_s=1.5,
    yaw_accel_rad_s2=3.0,
)  # fmt: skip
SURE = HistogramConfig(hit_gain=15, miss_loss=15, cell_m=0.05, wide_sectors=4)
PERIOD = 0.05


def scan_of_box(x0, x1, half, pose=SE2(0.0, 0.0, 0.0)) -> Scan:  # noqa: B008, frozen
    """Return what a full circle of beams sees of a box ahead, from x0 to x1 and +-half wide."""
    angles = -np.pi + 2.0 * np.pi * np.arange(720) / 720
    ux, uy = np.cos(angles + pose.yaw), np.sin(angles + pose.yaw)
    with np.errstate(divide="ignore", invalid="ignore"):
        ax, bx = (x0 - pose.x) / ux, (x1 - pose.x) / ux
        ay, by = (-half - pose.y) / uy, (half - pose.y) / uy
    enter = np.maximum(np.minimum(ax, bx), np.minimum(ay, by))
    leave = np.minimum(np.maximum(ax, bx), np.maximum(ay, by))
    ranges = np.where((enter < leave) & (enter > 0.0), enter, np.inf)
    ranges[ranges > 4.0] = np.inf
    return Scan(ranges, -np.pi, 2.0 * np.pi / 720, 0.02, 4.0)


def method(config=SURE, robot=ROBOT) -> VfhPlus:
    return VfhPlus(robot, config, Cycle(period=PERIOD))


def bearing_of(command) -> float:
    return float(np.degrees(np.arctan2(command.y, command.x)))


def decide(planner, scan, goal=(6.0, 0.0), velocity=STILL):
    point = np.array(goal)
    seen = Obstacles(scan, SE2.identity())
    return planner.decide(RobotState(velocity, velocity), seen, Goal(point, np.hypot(*point)))


def test_around_a_box_by_hand():
    """A face at 1.5 m, 0.6 m to the left and right. Its corner is at 21.8 degrees and 1.616 m;
    enlarged by 0.3 m: asin(0.3 / 1.616) = 10.7, so 32.5 degrees are blocked: sectors to 30. The
    opening begins at 35 degrees; half of s_max = 4 sectors is kept: 45 degrees."""
    command = decide(method(), scan_of_box(1.5, 3.0, 0.6), goal=(6.0, 0.6)).command
    assert bearing_of(command) == pytest.approx(45.0)


def test_what_was_chosen_last_holds_against_a_goal_a_little_on_the_other_side():
    planner, scan = method(), scan_of_box(1.5, 3.0, 0.6)
    assert bearing_of(decide(planner, scan, goal=(6.0, 0.6)).command) > 0.0
    assert bearing_of(decide(planner, scan, goal=(6.0, -0.3)).command) > 0.0
    assert bearing_of(decide(method(), scan, goal=(6.0, -0.3)).command) < 0.0


def test_a_box_beyond_the_window_or_beyond_the_goal_does_not_count():
    far = decide(method(), scan_of_box(2.5, 3.0, 0.6)).command
    behind = decide(method(), scan_of_box(1.5, 3.0, 0.6), goal=(1.0, 0.0)).command
    assert bearing_of(far) == bearing_of(behind) == 0.0


def test_at_speed_the_turning_circle_masks_a_side_and_standing_it_does_not():
    """0.8 m/s at 1 m/s^2: circles of 0.64 m. A post 0.55 m aside closes what lies beyond it."""
    scan = scan_of_box(-0.02, 0.02, 0.0)
    ranges = scan.ranges.copy()
    ranges[np.abs(scan.angles - np.pi / 2) < 0.03] = 0.55
    scan = replace(scan, ranges=ranges)
    goal = (-2.0, 3.0)  # 124 degrees to the left: beyond the post
    standing = bearing_of(decide(method(), scan, goal=goal).command)
    assert standing == pytest.approx(123.7, abs=0.1) or standing > 100.0
    moving = decide(method(), scan, goal=goal, velocity=Velocity(0.8, 0.0, 0.0)).command
    assert bearing_of(moving) < 90.0


def test_walled_in_it_is_blocked_and_says_so():
    scan = scan_of_box(-9.0, -8.0, 0.1)
    shut = replace(scan, ranges=np.full(720, 0.5))
    decision = decide(method(), shut)
    assert decision.state == BLOCKED and decision.reason and decision.command == STILL


@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_a_whole_drive_around_a_box_is_quick_and_touches_nothing(drive):
    """Clock as in the thesis's static obstacle: at most 1.1 (path / speed + 1 s)."""
    robot = replace(ROBOT, drive=drive)
    planner, pose, velocity = method(robot=robot), SE2(0.0, 0.05, 0.0), STILL
    poses, moved = [pose], SE2.identity()
    while pose.x < 4.0 and len(poses) < 400:
        point = (pose.inverse() @ np.array([[12.0, 0.0]]))[0]
        seen = Obstacles(scan_of_box(2.7, 3.3, 0.3, pose), SE2.identity())
        decision = planner.decide(
            RobotState(velocity, velocity, moved), seen, Goal(point, float(np.hypot(*point)))
        )
        assert decision.state == DRIVING
        velocity = ramped(velocity, decision.command, robot, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
        poses.append(pose)
    xy = np.array([(p.x, p.y) for p in poses])
    off = np.maximum(np.abs(xy - [3.0, 0.0]) - [0.3, 0.3], 0.0)
    assert np.hypot(*off.T).min() > robot.radius_m
    path = np.hypot(*np.diff(xy, axis=0).T).sum()
    assert len(poses) * PERIOD <= 1.1 * (path / robot.speed_m_s + 1.0)
