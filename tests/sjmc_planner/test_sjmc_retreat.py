"""When SJMC backs out of where it is stuck."""

from __future__ import annotations

import math

import pytest

from floornav_common.se2 import SE2
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.planning import DRIVING, STILL, TURNING, WAITING, Decision, RobotState, Velocity
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_retreat import Retreat

PERIOD = 0.05
TURNS, DRIVES = Decision(STILL, TURNING), Decision(STILL, DRIVING)
WAITS = Decision(STILL, WAITING)
AT_REST = RobotState(STILL)


def moving(way: float, speed: float = 0.5) -> RobotState:
    return RobotState(Velocity(speed, 0.0, 0.0), moved=SE2(way, 0.0, 0.0))


def arrived(meters: float = 0.4) -> Retreat:
    retreat = Retreat(SjmcConfig(backs_off_m=0.5), PERIOD)
    retreat.note(moving(meters))
    return retreat


def test_it_may_back_as_far_as_it_came_and_no_farther_than_set() -> None:
    assert arrived(0.3).behind == pytest.approx(0.3)
    assert arrived(2.0).behind == pytest.approx(0.5)
    retreat = arrived(0.3)
    retreat.note(moving(-0.1, -0.15))
    assert retreat.behind == pytest.approx(0.2)


def test_a_course_that_comes_and_goes_is_none() -> None:
    retreat, due = arrived(), []
    for k in range(50):
        retreat.note(AT_REST)
        due.append(retreat.is_due(TURNS if k % 2 else None))
    assert not any(due[:38]) and any(due)


def test_it_backs_for_a_while_and_then_looks_again() -> None:
    retreat = arrived()
    for _ in range(25):
        retreat.note(AT_REST)
        retreat.is_due(None)
    assert retreat.is_due(TURNS)
    for _ in range(21):
        retreat.note(moving(-0.01, -0.15))
    assert not retreat.is_due(TURNS)


def test_driving_on_forgets_that_it_was_stuck() -> None:
    retreat = arrived()
    for _ in range(19):
        retreat.note(AT_REST)
        retreat.is_due(None)
    retreat.is_due(DRIVES)
    assert not retreat.is_due(None)


def test_after_standing_for_long_among_people_it_gives_them_room() -> None:
    retreat, due = arrived(), []
    for _ in range(60):
        retreat.note(AT_REST)
        due.append(retreat.is_due(WAITS))
    assert not any(due[:49]) and all(due[52:])


def test_it_backs_along_the_arc_that_it_came() -> None:
    """Driven on an arc to the left of 1 m radius, it comes back to where that began."""
    retreat = Retreat(SjmcConfig(), PERIOD)
    at, step = SE2.identity(), moved_by(Velocity(0.5, 0.0, 0.5), PERIOD)
    for _ in range(40):
        at = at @ step
        retreat.note(RobotState(Velocity(0.5, 0.0, 0.5), moved=step))
    assert at.yaw == pytest.approx(1.0)
    place = at @ retreat.place
    assert math.hypot(place.x, place.y - 1.0) == pytest.approx(1.0, abs=0.001)
    assert 0.2 < retreat.place.distance < 0.4 and retreat.place.yaw < -0.2
    for _ in range(110):
        back = retreat.back(-0.15)
        moved = moved_by(back, PERIOD)
        at = at @ moved
        retreat.note(RobotState(back, moved=moved))
        assert math.hypot(at.x, at.y - 1.0) == pytest.approx(1.0, abs=0.02)
    assert at.yaw == pytest.approx(1.0 - 110 * PERIOD * 0.15, abs=0.05)


def test_the_way_that_it_came_is_at_most_gone_once() -> None:
    """What was backed over is no way any more: at its start there is none left to back along."""
    retreat = arrived(0.1)
    retreat.note(moving(0.1))
    for _ in range(30):
        retreat.note(moving(-0.01, -0.15))
    assert not any(retreat.is_due(None) for _ in range(60))


def test_who_came_no_way_backs_none() -> None:
    retreat = Retreat(SjmcConfig(), PERIOD)
    assert not any(retreat.is_due(None) for _ in range(60))
