"""When SJMC backs out of where it is stuck."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sjmc_scenes import ROBOT

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
    retreat = Retreat(ROBOT, SjmcConfig(backs_off_m=0.5), PERIOD)
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
    retreat = Retreat(ROBOT, SjmcConfig(), PERIOD)
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
    retreat = Retreat(ROBOT, SjmcConfig(), PERIOD)
    assert not any(retreat.is_due(None) for _ in range(60))


def test_a_place_beside_it_is_backed_to_no_faster_than_it_turns() -> None:
    """After 0.06 m and 1.4 rad on the spot the way back is a bend of 33 1/m: w alone is at most."""
    retreat = Retreat(ROBOT, SjmcConfig(), PERIOD)
    for _ in range(2):
        retreat.note(moving(0.03))
    for _ in range(14):
        retreat.note(RobotState(Velocity(0.0, 0.0, 1.2), moved=SE2(0.0, 0.0, 0.1)))
    back = retreat.back(-0.15)
    assert -0.15 < back.x < 0.0 and abs(back.yaw_rate) == pytest.approx(ROBOT.yaw_rate_rad_s)
    x, y = retreat.place.x, retreat.place.y
    assert back.yaw_rate / back.x == pytest.approx(2.0 * y / (x * x + y * y))


STEPS = st.lists(st.tuples(st.floats(-0.02, 0.05), st.floats(-0.15, 0.15)), max_size=60)


@settings(max_examples=60)
@given(steps=STEPS, fastest=st.floats(0.02, 1.0), speed=st.floats(-0.5, -0.01))
def test_it_backs_within_its_limits_whatever_way_it_came(
    steps: list[tuple[float, float]], fastest: float, speed: float
) -> None:
    robot = replace(ROBOT, speed_m_s=fastest)
    retreat = Retreat(robot, SjmcConfig(), PERIOD)
    for x, yaw in steps:
        retreat.note(RobotState(Velocity(x / PERIOD, 0.0, yaw / PERIOD), moved=SE2(x, 0.0, yaw)))
    back = retreat.back(speed)
    assert -min(fastest, -speed) - 1e-9 <= back.x < 0.0
    assert abs(back.yaw_rate) <= robot.yaw_rate_rad_s + 1e-9
