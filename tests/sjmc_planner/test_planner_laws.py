"""What every planning method keeps to, whatever it is for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.planning import (
    DRIVING,
    REACHED,
    STILL,
    TURNING,
    Decision,
    Goal,
    Obstacles,
    RobotState,
    Velocity,
)

PERIOD = 0.05
NUM_BEAMS = 360
ROBOT = RobotConfig(
    radius_m=0.3, margin_m=0.05, speed_m_s=0.6, accel_m_s2=0.8, yaw_rate_rad_s=1.2,
    yaw_accel_rad_s2=2.5, idle_time_s=0.03,
)  # fmt: skip
# These two are kept as published, with what was published of braking in time: nothing.
WITHOUT_STOPPING = {"omni_static", "sjmc_published"}
AT_START = SE2(0.0, 0.0, 0.0)
# x, y, vx, vy of people; in the first two a robot without a course crept towards somebody.
CORRIDORS = [
    [(3.8, -0.61, -0.82, -0.22), (2.02, -0.66, -0.36, 0.44), (1.38, -0.2, -0.2, 0.38)],
    [(1.57, 0.0, 0.11, 0.41), (1.06, 0.39, -0.61, -0.36), (1.42, 0.71, 0.15, 0.02)],
    [(3.0, 0.1, -0.5, 0.0), (4.0, -0.4, -0.8, 0.1), (2.5, 0.8, 0.1, -0.3)],
]
NAMES, DRIVES = sorted(METHODS), ("omni", "differential")
FEW = settings(max_examples=15)

every_method = pytest.mark.parametrize("name", NAMES)
every_drive = pytest.mark.parametrize("drive", DRIVES)
stopping_methods = pytest.mark.parametrize(
    "name", [name for name in NAMES if name not in WITHOUT_STOPPING]
)


def planner(name, drive):
    config = LocalPlannerConfig(
        method=name, robot=replace(ROBOT, drive=drive), control_period_s=PERIOD
    )
    return make_method(config)


def scan_of(ranges, range_min=0.05, range_max=6.0) -> Scan:
    """Return a full circle whose first beam looks backward; symmetric about straight ahead."""
    step = 2.0 * np.pi / NUM_BEAMS
    return Scan(np.asarray(ranges, dtype=float), -np.pi + 0.5 * step, step, range_min, range_max)


def open_scan() -> Scan:
    return scan_of(np.full(NUM_BEAMS, np.inf))


def disks_scan(disks, pose=AT_START, range_max=6.0) -> Scan:
    """Return what a laser at a pose sees of disks (x, y, radius)."""
    scan = open_scan()
    centers = pose.inverse() @ np.array([d[:2] for d in disks], dtype=float).reshape(-1, 2)
    ranges = scan.ranges.copy()
    for (x, y), (_, _, radius) in zip(centers, disks, strict=True):
        along = x * np.cos(scan.angles) + y * np.sin(scan.angles)
        aside2 = x * x + y * y - along**2
        hit = (aside2 < radius**2) & (along > 0.0)
        ranges = np.where(
            hit, np.minimum(ranges, along - np.sqrt(np.maximum(radius**2 - aside2, 0.0))), ranges
        )
    return replace(scan, ranges=np.where(ranges > range_max, np.inf, ranges))


def goal_at(x, y) -> Goal:
    return Goal(np.array([x, y]), float(np.hypot(x, y)))


def decide(method, scan, goal, velocity=STILL, num=3) -> Decision:
    """Return what it decides after seeing the same a few times: trackers need a moment."""
    for _ in range(num):
        decision = method.decide(
            RobotState(velocity, velocity, moved_by(velocity, PERIOD)),
            Obstacles(replace(scan), SE2.identity()), goal,
        )  # fmt: skip
    return decision


def driven(name, drive, disks, goal, limit_s=40.0):
    """Drive by a perfect base and laser; return the poses and whether the goal was reached."""
    method, robot = planner(name, drive), replace(ROBOT, drive=drive)
    pose, velocity, moved = SE2.identity(), STILL, SE2.identity()
    poses = [pose]
    for _ in range(round(limit_s / PERIOD)):
        point = (pose.inverse() @ np.array([goal], dtype=float))[0]
        decision = method.decide(
            RobotState(velocity, velocity, moved),
            Obstacles(disks_scan(disks, pose), SE2.identity()), goal_at(*point),
        )  # fmt: skip
        if decision.state == REACHED:
            return poses, True
        velocity = ramped(velocity, decision.command, robot, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
        poses.append(pose)
    return poses, False


@every_method
@every_drive
def test_with_nothing_around_it_drives_straight_for_the_goal(name, drive):
    decision = decide(planner(name, drive), open_scan(), goal_at(4.0, 0.0))
    assert decision.state == DRIVING and decision.reason == ""
    assert decision.command == Velocity(pytest.approx(0.6), pytest.approx(0.0), pytest.approx(0.0))


@every_method
def test_with_nothing_around_it_drives_straight_for_a_goal_anywhere(name):
    """A holonomic robot; half of a direction's step (1 degree) is what the choice may be off."""
    for bearing in np.radians([10.0, -50.0, 130.0]):
        goal = goal_at(4.0 * np.cos(bearing), 4.0 * np.sin(bearing))
        command = decide(planner(name, "omni"), open_scan(), goal).command
        assert np.arctan2(command.y, command.x) == pytest.approx(bearing, abs=0.0175)


@every_method
@every_drive
def test_a_whole_drive_in_the_open_is_straight(name, drive):
    poses, is_there = driven(name, drive, [], (3.0, 0.0))
    assert is_there and max(abs(pose.y) for pose in poses) < 1e-6


@every_method
@every_drive
def test_at_the_goal_it_stands(name, drive):
    decision = decide(planner(name, drive), open_scan(), goal_at(0.02, 0.0))
    assert decision.state == REACHED and decision.command == STILL


distance = st.one_of(
    st.floats(0.06, 5.9), st.just(np.inf), st.just(np.nan), st.just(-np.inf), st.just(0.0)
)


@st.composite
def scenes(draw):
    """Scans of pieces, each of one kind, and how the robot moves."""
    edges = sorted(draw(st.lists(st.integers(0, NUM_BEAMS), min_size=1, max_size=8)))
    ranges = np.full(NUM_BEAMS, draw(distance))
    for start, end in zip(edges, [*edges[1:], NUM_BEAMS], strict=True):
        ranges[start:end] = draw(distance)
    speed, yaw_rate = draw(st.floats(0.0, 0.6)), draw(st.floats(-1.2, 1.2))
    bearing, far = draw(st.floats(-3.1, 3.1)), draw(st.floats(0.1, 8.0))
    goal = goal_at(far * np.cos(bearing), far * np.sin(bearing))
    return scan_of(ranges), speed, yaw_rate, goal


def moving(drive, speed, yaw_rate):
    return Velocity(speed, 0.0, yaw_rate if drive == "differential" else 0.0)


@every_method
@every_drive
@FEW
@given(scene=scenes())
def test_no_command_is_beyond_the_robots_limits(name, drive, scene):
    scan, speed, yaw_rate, goal = scene
    decision = decide(planner(name, drive), scan, goal, moving(drive, speed, yaw_rate))
    assert decision.command.speed <= ROBOT.speed_m_s + 1e-9
    assert abs(decision.command.yaw_rate) <= ROBOT.yaw_rate_rad_s + 1e-9
    if drive == "differential":
        assert decision.command.y == 0.0
    else:
        assert decision.command.yaw_rate == 0.0


@every_drive
@pytest.mark.parametrize("people", CORRIDORS)
def test_sjmc_is_never_faster_than_its_model_in_any_state(drive, people, monkeypatch):
    """Three people about in a narrow corridor; the bound is that of the course driven along."""
    method, robot, moments, asked = planner("sjmc", drive), replace(ROBOT, drive=drive), [], 0
    of = method._moments.of
    monkeypatch.setattr(method._moments, "of", lambda *a: moments.append(of(*a)) or moments[-1])
    people = np.array(people)
    walls = [(x, y, 0.15) for x in np.arange(-1.0, 6.0, 0.25) for y in (-0.9, 0.9)]
    pose, velocity, moved = SE2.identity(), STILL, SE2.identity()
    for k in range(100):
        places = people[:, :2] + min(k * PERIOD, 2.0) * people[:, 2:]
        scan = disks_scan([*walls, *((x, y, 0.2) for x, y in places)], pose)
        point = (pose.inverse() @ np.array([[6.0, 0.0]]))[0]
        state = RobotState(velocity, velocity, moved)
        decision = method.decide(state, Obstacles(scan, SE2.identity()), goal_at(*point))
        command = decision.command
        # A differential robot's course is the target's where it does not turn to another one.
        course = np.arctan2(command.y, command.x)
        if drive == "differential":
            course = np.arctan2(point[1], point[0])
        if command.x > 0.03 and (drive == "omni" or decision.state != TURNING):
            asked += 1
            assert command.speed <= method._in_the_way(course, moments[-1]).bound + 1e-6
        velocity = ramped(velocity, command, robot, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
    assert asked > 5


@every_method
@every_drive
@FEW
@given(scene=scenes())
def test_who_does_not_drive_as_wanted_says_why(name, drive, scene):
    scan, speed, yaw_rate, goal = scene
    decision = decide(planner(name, drive), scan, goal, moving(drive, speed, yaw_rate))
    assert decision.state in (DRIVING, TURNING, REACHED) or decision.reason


@every_method
@every_drive
@pytest.mark.parametrize("seed", range(8))
def test_a_mirrored_scene_has_the_mirrored_command(name, drive, seed):
    """Random ranges have no two equal ways, which nothing but a side could tell apart."""
    rng = np.random.default_rng(seed)
    disks = [(*rng.uniform(-4.0, 4.0, 2), rng.uniform(0.1, 0.5)) for _ in range(6)]
    disks = [d for d in disks if np.hypot(*d[:2]) > d[2] + 0.4]
    goal = rng.uniform((0.5, -4.0), 4.0)  # straight behind, either side is right
    speed, w = rng.uniform(0.0, 0.6), rng.uniform(-1.0, 1.0)
    ours, theirs = planner(name, drive), planner(name, drive)
    scan = disks_scan(disks)
    noisy = scan.ranges + rng.normal(0.0, 0.01, NUM_BEAMS)
    for _ in range(3):
        left = decide(ours, scan_of(noisy), goal_at(*goal), moving(drive, speed, w), num=1)
        right = decide(
            theirs, scan_of(noisy[::-1]), goal_at(goal[0], -goal[1]), moving(drive, speed, -w),
            num=1,
        )  # fmt: skip
    a, b = left.command, right.command
    assert (a.x, a.y, a.yaw_rate) == pytest.approx((b.x, -b.y, -b.yaw_rate), abs=1e-6)
    assert left.state == right.state


@pytest.mark.parametrize(
    ("name", "drive"),
    # Published for holonomic robots: a differential one it turns to a course while driving on.
    [(n, d) for n in NAMES for d in DRIVES if (n, d) != ("omni_static", "differential")],
)
def test_what_was_not_looked_at_is_not_free(name, drive):
    """Nothing seen for 60 degrees about straight ahead, and nothing in the way elsewhere."""
    scan = open_scan()
    ranges = np.where(np.abs(scan.angles) < np.radians(30.0), np.nan, scan.ranges)
    command = decide(planner(name, drive), scan_of(ranges), goal_at(4.0, 0.0)).command
    bearing = np.arctan2(command.y, command.x)
    assert command.speed < 1e-3 or abs(bearing) > np.radians(30.0)


@every_method
@every_drive
def test_who_sees_nothing_stays(name, drive):
    scan = scan_of(np.full(NUM_BEAMS, np.nan))
    method, velocity = planner(name, drive), Velocity(0.3, 0.0, 0.0)
    for _ in range(12):  # 0.3 m/s at 0.8 m/s^2 is still after 0.4 s
        decision = decide(method, scan, goal_at(4.0, 0.0), velocity, num=1)
        velocity = ramped(velocity, decision.command, replace(ROBOT, drive=drive), PERIOD)
        is_turning_on_the_spot = decision.command.speed == 0.0 and not decision.command.is_still
        assert is_turning_on_the_spot or (decision.state != DRIVING and decision.reason)
    assert velocity.speed < 1e-3


@every_method
@every_drive
def test_who_is_too_near_to_everything_to_measure_it_stays(name, drive):
    """-inf all around, as a laser gives it that something covers."""
    method = planner(name, drive)
    command = decide(method, scan_of(np.full(NUM_BEAMS, -np.inf)), goal_at(4.0, 0.0)).command
    assert command.speed < 1e-3


@every_method
@every_drive
def test_what_is_too_near_to_be_measured_stands_there(name, drive):
    """-inf ahead with a laser that is blind up to 0.4 m: 0.05 m of room is left at most."""
    scan = open_scan()
    ranges = np.where(np.abs(scan.angles) < np.radians(30.0), -np.inf, scan.ranges)
    method = planner(name, drive)
    command = decide(method, scan_of(ranges, range_min=0.4), goal_at(4.0, 0.0)).command
    ahead = command.speed * np.cos(np.arctan2(command.y, command.x))
    assert ahead * (0.03 + PERIOD) + ahead**2 / (2.0 * ROBOT.accel_m_s2) <= 0.1


@stopping_methods
@every_drive
@pytest.mark.parametrize("seed", range(3))
def test_it_touches_nothing_that_stands(name, drive, seed):
    """Disks across the way: it gets through or it stops, and it touches none of them."""
    rng = np.random.default_rng(seed)
    disks = [(*rng.uniform((1.0, -1.5), (5.0, 1.5)), rng.uniform(0.1, 0.4)) for _ in range(7)]
    disks = [d for d in disks if np.hypot(d[0] - 6.0, d[1]) > d[2] + 0.5]
    poses, _ = driven(name, drive, disks, (6.0, 0.0), limit_s=25.0)
    xy = np.array([(pose.x, pose.y) for pose in poses])
    for x, y, radius in disks:
        assert np.hypot(xy[:, 0] - x, xy[:, 1] - y).min() >= radius + ROBOT.radius_m
