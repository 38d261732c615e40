"""The choice of a direction (Step 5), the cases where the paper is silent, and whole drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, OmniConfig, RobotConfig
from sjmc_planner.limited_motion import limited_position, limited_velocity, moved_by, ramped
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.omni_velocity import directions, preference
from sjmc_planner.planning import (
    BLOCKED,
    BRAKING,
    DRIVING,
    REACHED,
    STILL,
    Goal,
    Obstacles,
    RobotState,
    Velocity,
)

PERIOD = 0.05
RADIUS = 0.1
NUM_BEAMS = 360
PUBLISHED = OmniConfig(num_directions=32, num_speeds=1, keeps_stoppable=False)


def method(name="omni_velocity", drive="omni", omni=None):
    robot = RobotConfig(drive=drive, radius_m=0.08, margin_m=0.02)
    omni = OmniConfig() if omni is None else omni
    return make_method(
        LocalPlannerConfig(method=name, robot=robot, omni=omni, control_period_s=PERIOD)
    )


def scan_of(disks: np.ndarray, pose: SE2, range_max: float = 4.0) -> Scan:
    """Return what a laser at a pose sees of disks, rows (x, y, radius)."""
    angles = -np.pi + 2.0 * np.pi * np.arange(NUM_BEAMS) / NUM_BEAMS
    centers = pose.inverse() @ np.asarray(disks, dtype=float).reshape(-1, 3)[:, :2]
    ranges = np.full(NUM_BEAMS, np.inf)
    for (x, y), r in zip(centers, np.asarray(disks).reshape(-1, 3)[:, 2], strict=True):
        along = x * np.cos(angles) + y * np.sin(angles)
        aside2 = x * x + y * y - along**2
        hit = (aside2 < r * r) & (along > 0.0)
        near = along - np.sqrt(np.maximum(r * r - aside2, 0.0))
        ranges = np.where(hit, np.minimum(ranges, near), ranges)
    ranges[ranges > range_max] = np.inf
    return Scan(ranges, -np.pi, 2.0 * np.pi / NUM_BEAMS, 0.01, range_max)


def decide(planner, disks, velocity=STILL, goal=(3.0, 0.0), **kwargs):
    seen = Obstacles(scan_of(np.array(disks), SE2.identity(), **kwargs), SE2.identity())
    point = np.array(goal)
    return planner.decide(RobotState(velocity), seen, Goal(point, float(np.hypot(*point))))


def bearing_of(decision) -> float:
    return float(np.arctan2(decision.command.y, decision.command.x))


def test_the_directions_of_eq_11_by_hand():
    assert directions(4) == pytest.approx([0.0, np.pi / 2, np.pi, -np.pi / 2])


def test_the_open_direction_nearest_the_goal_is_taken():
    times = np.array([2.0, 3.0, 9.0, 3.0])
    order = preference(times, directions(4), 0.1, 0.0, 2.75)
    assert order.tolist() == [1, 3, 2, 0]


def test_free_for_just_as_long_as_asked_is_open():
    """T_j >= T_th (Step 5); the way straight at the goal wins only if it is open."""
    for time, best in ((2.75, 0), (2.7499, 1)):
        times = np.array([time, np.inf, 1.0, 1.0])
        assert preference(times, directions(4), 0.1, 0.0, 2.75)[0] == best


def test_with_none_open_the_one_free_longest_comes_first():
    times = np.array([1.0, 0.5, 2.0, 2.0])
    order = preference(times, directions(4), -0.1, 0.0, 2.75)
    assert order.tolist() == [3, 2, 0, 1]


def test_of_two_as_near_to_the_goal_the_one_nearer_to_the_motion_is_taken():
    times = np.array([0.0, 9.0, 0.0, 9.0])
    assert preference(times, directions(4), 0.0, -0.3, 2.75)[0] == 3
    assert preference(times, directions(4), 0.0, 0.3, 2.75)[0] == 1


@pytest.mark.parametrize("name", sorted(METHODS))
@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_in_the_open_it_drives_straight_at_the_goal(name, drive):
    decision = decide(method(name, drive), [])
    assert decision.state == DRIVING
    assert decision.command.x == pytest.approx(0.4) and decision.command.yaw_rate == 0.0


@pytest.mark.parametrize("name", sorted(METHODS))
def test_at_the_goal_it_stands(name):
    decision = decide(method(name), [], goal=(0.02, 0.0))
    assert decision.state == REACHED and decision.command == STILL


def test_it_goes_no_faster_than_it_can_brake_before_the_goal():
    decision = decide(method(), [], velocity=Velocity(0.2, 0.0, 0.0), goal=(0.1, 0.0))
    v = decision.command.x
    assert v * (0.03 + PERIOD) + v * v / 0.6 == pytest.approx(0.1)


def test_what_stands_behind_the_goal_is_no_reason_to_turn():
    decision = decide(method(), [(1.0, 0.0, 0.3)], goal=(0.4, 0.0))
    assert bearing_of(decision) == 0.0
    assert bearing_of(decide(method(), [(1.0, 0.0, 0.3)])) != 0.0


def test_with_velocity_it_turns_farther_than_without():
    """Moving at an obstacle, a small turn comes too late; distances alone do not show that."""
    disks, v = [(0.9, 0.0, 0.15)], Velocity(0.4, 0.0, 0.0)
    fine = replace(PUBLISHED, num_directions=180)
    aware = decide(method(omni=fine), disks, v)
    static = decide(method("omni_static", omni=fine), disks, v)
    assert abs(bearing_of(aware)) > abs(bearing_of(static)) > 0.0


def test_where_all_full_speed_ways_are_short_it_goes_slower():
    ring = [(0.9 * np.cos(a), 0.9 * np.sin(a), 0.1) for a in np.linspace(0, 2 * np.pi, 40)]
    slow = decide(method(), ring)
    published = decide(method(omni=PUBLISHED), ring)
    assert slow.state == DRIVING
    assert slow.command.speed <= 0.2 + 1e-9
    assert published.command.speed == pytest.approx(0.4)


def test_too_fast_to_turn_it_brakes():
    ring = [(0.35 * np.cos(a), 0.35 * np.sin(a), 0.1) for a in np.linspace(0, 2 * np.pi, 40)]
    decision = decide(method(), ring, Velocity(0.4, 0.0, 0.0))
    assert (
        decision.state == BRAKING
        and decision.command == STILL
        and "room to stop" in decision.reason
    )


def test_shut_in_and_standing_it_is_blocked():
    seen = Obstacles(Scan(np.full(36, -np.inf), -np.pi, np.pi / 18, 0.1, 4.0), SE2.identity())
    goal = Goal(np.array([2.0, 0.0]), 2.0)
    decision = method().decide(RobotState(STILL), seen, goal)
    assert decision.state == BLOCKED and decision.command == STILL and decision.reason


def test_it_does_not_drive_faster_than_it_can_stop_within_the_horizon():
    decision = decide(method(), [], Velocity(0.4, 0.0, 0.0), range_max=0.3)
    assert decision.state == BRAKING
    assert decide(method(), [], Velocity(0.05, 0.0, 0.0), range_max=0.3).state == DRIVING


def test_a_mirrored_world_gives_the_mirrored_command():
    disks = np.array([(0.8, 0.1, 0.2), (1.2, -0.6, 0.2)])
    mirror = disks * (1.0, -1.0, 1.0)
    v = Velocity(0.3, 0.05, 0.0)
    one = decide(method(), disks, v, goal=(3.0, 0.3))
    other = decide(method(), mirror, replace(v, y=-v.y), goal=(3.0, -0.3))
    assert (one.command.x, one.command.y) == pytest.approx((other.command.x, -other.command.y))


def test_debug_shows_a_way_for_each_direction():
    planner = method()
    seen = Obstacles(scan_of(np.array([(1.0, 0.0, 0.2)]), SE2.identity()), SE2.identity())
    decision = planner.decide(
        RobotState(STILL), seen, Goal(np.array([3.0, 0.0]), 3.0), has_debug=True
    )
    debug = decision.debug
    assert len(debug.candidates) == len(debug.times) == 180
    taken = debug.candidates[debug.chosen][-1]
    assert np.arctan2(taken[1], taken[0]) == pytest.approx(bearing_of(decision), abs=1e-6)
    assert np.nanmin(np.hypot(*debug.grown.T)) == pytest.approx(0.7, abs=1e-3)


@pytest.mark.parametrize("drive", ["omni", "differential"])
@pytest.mark.parametrize("seed", range(8))
def test_no_standing_disk_is_ever_touched(drive, seed):
    """The robot moves by eq. 10 with the idle time; disks stand anywhere, dead ends too."""
    rng = np.random.default_rng([seed, 7])
    disks = np.column_stack(
        (rng.uniform(0.5, 3.0, 12), rng.uniform(-1.2, 1.2, 12), np.full(12, 0.1))
    )
    clearances, is_reached = drive_through(method(drive=drive), disks, drive)
    assert min(clearances) > 0.0
    assert is_reached or len(clearances) == NUM_CYCLES


NUM_CYCLES = 500


def drive_through(planner, disks, drive):
    """Return the distances to the disks at each cycle, and whether the goal was reached."""
    robot = RobotConfig(drive=drive, idle_time_s=0.03)
    pose, sent, moving = SE2.identity(), STILL, STILL
    clearances = []
    for _ in range(NUM_CYCLES):
        away = disks[:, :2] - (pose.x, pose.y)
        clearances.append(float((np.hypot(*away.T) - disks[:, 2]).min()) - 0.08)
        goal = (pose.inverse() @ np.array([[3.6, 0.0]]))[0]
        decision = planner.decide(
            RobotState(moving, sent), Obstacles(scan_of(disks, pose), SE2.identity()),
            Goal(goal, float(np.hypot(*goal))),
        )  # fmt: skip
        if decision.state == REACHED:
            return clearances, True
        before, sent = moving, decision.command
        moving = ramped(before, sent, robot, PERIOD)
        mean = Velocity(
            (before.x + moving.x) / 2, (before.y + moving.y) / 2,
            (before.yaw_rate + moving.yaw_rate) / 2,
        )  # fmt: skip
        pose = pose @ moved_by(mean, PERIOD)
    return clearances, False


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(0.0, 6.28))
def test_the_motion_predicted_is_the_motion_driven(vx, vy, angle):
    """A cycle of eq. 12 is what eq. 10 does to the velocity meanwhile."""
    va, vb = np.array([vx, vy]), 0.4 * np.array([np.cos(angle), np.sin(angle)])
    steps = np.array([limited_velocity(va, vb, 0.3, t) for t in np.linspace(0, PERIOD, 51)])
    driven = ((steps[1:] + steps[:-1]) / 2).mean(axis=0) * PERIOD
    assert limited_position(va, vb, 0.3, 0.0, PERIOD) == pytest.approx(driven, abs=1e-5)


@pytest.mark.parametrize("drive", ["omni", "differential"])
@pytest.mark.parametrize("goal", [(0.0, 2.0), (-2.0, 0.0)])
def test_with_nothing_seen_ahead_it_goes_another_way(drive, goal):
    ranges = np.full(NUM_BEAMS, np.inf)
    ranges[170:191] = np.nan
    scan = Scan(ranges, -np.pi, 2.0 * np.pi / NUM_BEAMS, 0.01, 4.0)
    point = np.array(goal)
    seen = Obstacles(scan, SE2.identity())
    decision = method(drive=drive).decide(RobotState(STILL), seen, Goal(point, 2.0))
    assert decision.state == DRIVING and not decision.command.is_still
    if drive == "omni":
        assert abs(bearing_of(decision)) > 1.0


@pytest.mark.parametrize("omni", [OmniConfig(), PUBLISHED])
def test_with_nothing_seen_at_all_it_stands(omni):
    scan = Scan(np.full(NUM_BEAMS, np.nan), -np.pi, 2.0 * np.pi / NUM_BEAMS, 0.01, 4.0)
    seen, goal = Obstacles(scan, SE2.identity()), Goal(np.array([2.0, 0.0]), 2.0)
    decision = method(omni=omni).decide(RobotState(STILL), seen, goal)
    assert decision.state == BLOCKED and decision.command.is_still
