"""How SJMC makes room for who comes too near even if it stops."""

from __future__ import annotations

import numpy as np
import pytest
from sjmc_scenes import CONFIG, ROBOT, goal_at, scan_of, watched

from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.methods import make_method
from sjmc_planner.planning import STILL, WAITING, Obstacles, RobotState, Velocity
from sjmc_planner.sjmc_region import box_of
from sjmc_planner.sjmc_rollout import Foresight
from sjmc_planner.sjmc_room import make_room
from sjmc_planner.sjmc_scene import Scene

RADIUS, BEHIND = 0.25, 0.5
CUTS = (0.75, 0.9, -0.3, -0.8)  # cuts the corner that a standing robot has there
RUNS_IN = (1.2, 0.1, -0.9, 0.0)  # straight at it, faster than it backs
FAR = (1.8, -1.2, 0.0, -0.6)  # walks away


def room(*people: tuple[float, float, float, float], behind: float = BEHIND, command=STILL):
    rows = np.array([(*person, RADIUS) for person in people])
    ends = BeamReader(0.1).read(Obstacles(scan_of([]), SE2.identity()))
    none = np.zeros((0, 2))
    is_moving = np.hypot(rows[:, 2], rows[:, 3]) > 0.1
    scene = Scene(ends, none, none, rows, np.arange(len(rows)), is_moving)
    sight = Foresight(ROBOT, box_of(ROBOT), 0.15, 2.5)
    stands = sight.look(STILL, 0.0, 0.0, 0.0, none, rows)
    state = RobotState(STILL, command)
    return make_room(state, scene, sight, stands, behind, ROBOT, CONFIG.sjmc)


def test_it_backs_before_who_cuts_its_corner_as_far_as_it_came() -> None:
    speed, course = room(CUTS)
    assert speed < 0.0 and course == 0.0
    without = room(CUTS, behind=0.0)
    assert without is None or without[0] > 0.0


def test_who_would_walk_over_it_anyway_meets_a_robot_that_does_not_back() -> None:
    answer = room(RUNS_IN)
    assert answer is None or answer[0] > 0.0


def test_among_several_it_backs_no_faster_than_slowly() -> None:
    alone, among = room(CUTS), room(CUTS, FAR)
    assert alone[0] == pytest.approx(-0.5)
    assert among[0] == pytest.approx(-0.15)


def test_once_it_backs_a_small_gain_is_enough_to_go_on() -> None:
    slight = (0.62, 0.8, 0.0, -0.8)
    assert room(slight, behind=0.03) is None
    goes_on = room(slight, behind=0.03, command=Velocity(-0.5, 0.0, 0.0))
    assert goes_on is not None and goes_on[0] < 0.0


def test_it_stands_while_one_of_several_is_right_before_it() -> None:
    """0.05 m beside the front corner, walking off to the left; another one walks on the left."""
    other = (1.5, 1.6, 0.2, 0.6, 0.0)
    near, off = (watched(make_method(CONFIG), [(0.1, y, 0.2, 0.0, 0.8), other], goal_at(12.0, 0.0))
                 for y in (0.55, 1.2))  # fmt: skip
    assert near.state == WAITING and near.command == STILL
    assert off.command.x > 0.0
