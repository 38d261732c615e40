"""How SJMC makes room for who comes too near even if it stops."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from sjmc_scenes import CONFIG, PERIOD, ROBOT, goal_at, people_scene, scan_of, watched

from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.methods import make_method
from sjmc_planner.planning import STILL, WAITING, Obstacles, RobotState, Velocity
from sjmc_planner.sjmc_moment import MomentReader
from sjmc_planner.sjmc_region import box_of
from sjmc_planner.sjmc_rollout import Foresight
from sjmc_planner.sjmc_room import make_room
from sjmc_planner.sjmc_scene import Scene

RADIUS, BEHIND = 0.25, 0.5
NONE = np.zeros((0, 2))
CUTS = (0.75, 0.9, -0.3, -0.8)  # cuts the corner that a standing robot has there
AT_IT = (1.5, 0.3, -1.0, 0.0)
RUNS_IN = (1.2, 0.1, -0.9, 0.0)  # straight at it, faster than it backs
FAR = (1.8, -1.2, 0.0, -0.6)  # walks away


def room(
    *people: tuple[float, float, float, float], behind: float = BEHIND, is_backing: bool = False,
    half_view: float = math.pi, robot: RobotConfig = ROBOT,
    things: np.ndarray = NONE,
):  # fmt: skip
    rows = np.array([(*person, RADIUS) for person in people])
    scan = scan_of([])
    scan = replace(scan, ranges=np.where(np.abs(scan.angles) <= half_view, scan.ranges, np.nan))
    ends = BeamReader(0.1).read(Obstacles(scan, SE2.identity()))
    is_moving = np.hypot(rows[:, 2], rows[:, 3]) > 0.1
    scene = Scene(ends, things, things, rows, np.arange(len(rows)), is_moving)
    sight = Foresight(robot, box_of(robot), 0.15, 2.5)
    stands = sight.look(STILL, 0.0, 0.0, 0.0, things, rows)
    state = RobotState(STILL)
    return make_room(state, scene, sight, stands, behind, robot, CONFIG.sjmc, is_backing)


def test_it_backs_before_who_cuts_its_corner_as_far_as_it_came() -> None:
    speed, course = room(CUTS)
    assert speed < 0.0 and course == 0.0
    without = room(CUTS, behind=0.0)
    assert without is None or without[0] > 0.0


def test_it_backs_into_nothing() -> None:
    """A pole 0.2 m behind it, on the way that it came."""
    pole = np.array([[-ROBOT.rear_m - 0.2, 0.0]])
    answer = room(CUTS, things=pole)
    assert answer is None or answer[0] > 0.0
    assert room(CUTS, things=pole - [1.0, 0.0])[0] < 0.0


@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_it_makes_no_room_where_no_beam_looked(drive: str) -> None:
    """A laser of 60 degrees, and somebody who walks at it at 1.2 m/s from 4.5 m ahead."""
    robot = replace(ROBOT, drive=drive, front_m=0.0, rear_m=0.0, half_width_m=0.0)
    method = make_method(replace(CONFIG, robot=robot))
    pose, velocity, moved = SE2.identity(), Velocity(0.4, 0.0, 0.0), SE2.identity()
    for k in range(70):
        person = (pose.inverse() @ np.array([[4.5 - 1.2 * k * PERIOD, 0.15]]))[0]
        scan = scan_of([(float(person[0]), float(person[1]), 0.2)])
        is_seen = np.abs(scan.angles) <= math.radians(30.0)
        scan = replace(scan, ranges=np.where(is_seen, scan.ranges, np.nan))
        goal = goal_at(*(pose.inverse() @ np.array([[8.0, 0.0]]))[0])
        command = method.decide(
            RobotState(velocity, velocity, moved), Obstacles(scan, SE2.identity()), goal
        ).command
        bearing = abs(math.atan2(command.y, command.x))
        assert command.x < 0.0 or command.speed < 1e-3 or bearing < math.radians(31.0)
        velocity = ramped(velocity, command, robot, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved


def test_it_turns_away_from_a_person_only_where_it_looked() -> None:
    """Straight at it: with a laser of 270 degrees it goes aside, with one of 60 it does not."""
    omni = replace(ROBOT, drive="omni")
    wide = room(AT_IT, behind=0.0, robot=omni)
    assert wide == (pytest.approx(ROBOT.speed_m_s), pytest.approx(math.radians(-100.0)))
    assert room(AT_IT, behind=0.0, robot=omni, half_view=math.radians(30.0)) is None


def test_who_would_walk_over_it_anyway_meets_a_robot_that_does_not_back() -> None:
    answer = room(RUNS_IN)
    assert answer is None or answer[0] > 0.0


def test_among_several_it_backs_no_faster_than_slowly() -> None:
    alone, among = room(CUTS), room(CUTS, FAR)
    assert alone[0] == pytest.approx(-0.5)
    assert among[0] == pytest.approx(-0.15)


@pytest.mark.parametrize(("closing", "is_met"), [(0.8, False), (0.9, True), (-0.9, False)])
def test_of_several_one_who_is_right_before_it_soon_counts(closing: float, is_met: bool) -> None:
    """0.5 m ahead of the front, 0.35 s later 0.22 m or 0.185 m: 0.2 m is near."""
    box, sight = box_of(ROBOT), Foresight(ROBOT, box_of(ROBOT), 0.15, 2.5)
    moments = MomentReader(ROBOT, CONFIG.sjmc, box, sight, 0.15)
    comes, other = (ROBOT.front_m + RADIUS + 0.5, 0.1, -closing, 0.0), (1.0, 2.0, 0.0, 0.5)
    goal, state = goal_at(12.0, 0.0), RobotState(STILL)
    among = moments.of(state, goal, people_scene(comes, other), np.zeros(2, bool))
    alone = moments.of(state, goal, people_scene(comes), np.zeros(1, bool))
    assert among.is_met == is_met and not alone.is_met


def test_once_it_backs_a_small_gain_is_enough_to_go_on() -> None:
    slight = (0.62, 0.8, 0.0, -0.8)
    assert room(slight, behind=0.03) is None
    goes_on = room(slight, behind=0.03, is_backing=True)
    assert goes_on is not None and goes_on[0] < 0.0


def test_it_stands_while_one_of_several_is_right_before_it() -> None:
    """0.05 m beside the front corner, walking off to the left; another one walks on the left."""
    other = (1.5, 1.6, 0.2, 0.6, 0.0)
    near, off = (watched(make_method(CONFIG), [(0.1, y, 0.2, 0.0, 0.8), other], goal_at(12.0, 0.0))
                 for y in (0.55, 1.2))  # fmt: skip
    assert near.state == WAITING and near.command == STILL
    assert off.command.x > 0.0
