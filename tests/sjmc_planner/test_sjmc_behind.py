"""Who went out of view behind the robot is minded for a while."""

from __future__ import annotations

import math

import pytest
from sjmc_scenes import people_scene

from floornav_common.se2 import SE2
from sjmc_planner.planning import STILL, RobotState
from sjmc_planner.sjmc_behind import Behind

PERIOD, VIEW = 0.1, math.radians(120.0)
STANDS = RobotState(STILL)
NOBODY = people_scene(half_view=VIEW)


def near_after(behind: Behind, num: int, state: RobotState = STANDS) -> bool:
    return [behind.is_near(state, NOBODY) for _ in range(num)][-1]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_who_goes_slowly_out_of_view_is_minded_for_three_seconds(side: float) -> None:
    behind, goes = Behind(1.4, PERIOD), (-0.8, 0.3 * side, -0.1, 0.0)
    assert behind.is_near(STANDS, people_scene(goes, half_view=VIEW))
    assert near_after(behind, 29)
    assert not near_after(behind, 2)


def test_who_walks_on_is_gone_once_out_of_reach() -> None:
    """From 0.8 m behind at 1.2 m/s it is 1.4 m behind after 0.5 s."""
    behind = Behind(1.4, PERIOD)
    assert behind.is_near(STANDS, people_scene((-0.8, 0.0, -1.2, 0.0), half_view=VIEW))
    assert near_after(behind, 4)
    assert not near_after(behind, 2)


def test_who_is_in_view_is_not_behind() -> None:
    behind = Behind(1.4, PERIOD)
    assert not behind.is_near(STANDS, people_scene((0.5, 0.8, -0.5, 0.0), half_view=VIEW))
    full = people_scene((-0.8, 0.0, 0.0, 0.0))
    assert not behind.is_near(STANDS, full)


def test_the_place_moves_with_the_robot_until_it_comes_into_view() -> None:
    """0.8 m behind: 0.4 m on it is 1.2 m behind, 0.3 m more and it is out of reach; or it turns."""
    behind, stands = Behind(1.4, PERIOD), people_scene((-0.8, 0.0, 0.0, 0.0), half_view=VIEW)
    behind.is_near(STANDS, stands)
    assert behind.is_near(RobotState(STILL, STILL, SE2(0.4, 0.0, 0.0)), NOBODY)
    assert not behind.is_near(RobotState(STILL, STILL, SE2(0.3, 0.0, 0.0)), NOBODY)
    behind.is_near(STANDS, stands)
    assert not behind.is_near(RobotState(STILL, STILL, SE2(0.0, 0.0, math.pi)), NOBODY)
    assert not behind.is_near(RobotState(STILL, STILL, SE2(0.0, 0.0, math.pi)), NOBODY)
