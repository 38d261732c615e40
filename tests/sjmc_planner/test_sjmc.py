"""SJMC with tracks: who is waited for, who is gone around, and how fast."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sjmc_scenes import CONFIG, PERIOD, ROBOT, goal_at, scan_of, watched

from floornav_common.se2 import SE2
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.methods import make_method
from sjmc_planner.planning import (
    BACKING,
    BRAKING,
    DRIVING,
    STILL,
    TURNING,
    WAITING,
    Obstacles,
    RobotState,
    Velocity,
)
from sjmc_planner.sjmc_speed import aware_time, stable_bound

FAR = goal_at(12.0, 0.0)
SJMC = CONFIG.sjmc
HALF = ROBOT.half_width_m + ROBOT.margin_m
TRACKED_M = 0.1  # by how much a tracked place or radius may be off


def sjmc():
    return make_method(CONFIG)


@settings(max_examples=25)
@given(x=st.floats(1.4, 4.0), y=st.floats(-0.2, 0.2))
def test_towards_who_stands_it_is_never_faster_than_the_model(x: float, y: float) -> None:
    decision = watched(sjmc(), [(x, y, 0.2)], FAR)
    distance = x - ROBOT.front_m - 0.2
    t_aware = aware_time(distance, SJMC.caution_m, SJMC.aware_s)
    t_avoid = max(HALF + 0.2 - abs(y) - TRACKED_M, 0.01) / SJMC.side_speed_m_s
    bound = stable_bound(distance + TRACKED_M, SJMC.danger_m, 0.0, t_aware, t_avoid)
    is_ahead = decision.state == DRIVING
    assert not is_ahead or decision.command.x <= bound + 1e-6
    assert decision.command.x <= ROBOT.speed_m_s + 1e-9


def test_far_from_who_stands_it_goes_straight_on_for_them_to_step_aside() -> None:
    decision = watched(sjmc(), [(3.5, 0.0, 0.2)], FAR)
    assert decision.state == DRIVING and abs(decision.command.yaw_rate) < 1e-6
    assert decision.command.x > 0.3


def test_who_stands_and_is_near_is_gone_around() -> None:
    decision = watched(sjmc(), [(1.5, 0.1, 0.2)], FAR)
    assert decision.state == TURNING and "does not yield" in decision.reason
    assert decision.command.yaw_rate < 0.0  # the person is to the left


def test_a_wide_thing_is_gone_around_and_not_waited_for() -> None:
    decision = watched(sjmc(), [(2.4, 0.1, 0.5)], FAR)
    assert decision.state == TURNING and decision.reason == "around a thing"


def test_who_walks_across_is_waited_for_and_the_reason_says_how_long() -> None:
    decision = watched(sjmc(), [(1.3, 0.5, 0.2, 0.0, -0.8)], FAR, num=16)
    assert decision.state == WAITING and decision.command == STILL
    assert decision.reason.startswith("for a person, 0.")


@pytest.mark.parametrize("thing", [(0.75, -0.55, 0.3), (0.85, -0.5, 0.35)])
def test_for_a_thing_it_waits_for_nobody_whoever_stands_about(thing: tuple[float, ...]) -> None:
    """Turning right into a thing, with somebody 3.6 m off to the side: all as with nobody there."""
    goal, turns = goal_at(8.8, 4.8), Velocity(0.8, 0.0, -0.8)
    alone, among = (
        watched(sjmc(), [thing, *others], goal, velocity=turns, num=4)
        for others in ([], [(1.0, -3.5, 0.2)])
    )
    assert (among.state, among.reason) == (alone.state, alone.reason)
    assert among.state == BRAKING and among.command == alone.command == STILL


def test_slower_for_a_thing_is_not_called_slower_for_a_person() -> None:
    """Straight on beside a pillar that it turns to: the pillar alone sets the speed."""
    pillar, aside = (0.5, -0.7, 0.3), (2.0, 3.0, 0.2)
    turns = Velocity(0.5, 0.0, -0.8)
    alone, among = (
        watched(sjmc(), [pillar, *others], FAR, velocity=turns, num=4) for others in ([], [aside])
    )
    assert alone.state == among.state == DRIVING and alone.command == among.command
    assert among.command.x < 0.6 * ROBOT.speed_m_s and among.reason == alone.reason == ""


def test_around_a_thing_is_said_of_things_whoever_does_not_yield_elsewhere() -> None:
    method, stands = sjmc(), (1.5, 0.1, 0.2)
    near = watched(method, [stands], FAR)
    assert near.reason == "around a person who does not yield"
    hidden = watched(method, [(1.2, -0.1, 0.5)], FAR, num=1)  # before the same person
    assert hidden.state == TURNING and hidden.reason == "around a thing"


def test_who_creeps_on_without_a_course_says_that_it_drives() -> None:
    """Between two walls that leave it no air it goes on slowly, as no other way is left."""
    walls = [(x, y, 0.1) for x in np.arange(-1.0, 3.0, 0.15) for y in (-0.41, 0.41)]
    goal = goal_at(6.0, 0.0)
    decision = watched(sjmc(), walls, goal)
    assert decision.command.x > 0.0 and decision.state == DRIVING
    assert decision.reason == "slowly: no course is open"


def test_beside_who_stands_it_slows_down() -> None:
    free = watched(sjmc(), [(2.0, 2.2, 0.2)], FAR).command.x
    beside = watched(sjmc(), [(2.0, 0.9, 0.2)], FAR)
    assert free == pytest.approx(ROBOT.speed_m_s) and beside.command.x < 0.7 * free
    assert beside.reason == "slower for a person"


def test_a_mirrored_scene_has_the_mirrored_command() -> None:
    disks = [(1.6, 0.15, 0.2, 0.0, 0.0), (2.5, -0.9, 0.5, 0.0, 0.0), (3.0, 1.0, 0.2, -0.2, -0.7)]
    flipped = [(x, -y, r, vx, -vy) for x, y, r, vx, vy in disks]
    one = watched(sjmc(), disks, goal_at(6.0, 0.5))
    other = watched(sjmc(), flipped, goal_at(6.0, -0.5))
    assert one.state == other.state and one.reason == other.reason
    assert one.command.x == pytest.approx(other.command.x, abs=1e-6)
    assert one.command.yaw_rate == pytest.approx(-other.command.yaw_rate, abs=1e-6)


def test_it_backs_only_on_the_way_that_it_came() -> None:
    """Somebody cuts its front corner; only who has driven may back, and the farther the faster."""
    walker, slowly = [(0.75, 0.9, 0.2, -0.3, -0.8)], Velocity(0.2, 0.0, 0.0)
    backs = [watched(sjmc(), walker, FAR, velocity=slowly, num=num) for num in (16, 30)]
    assert [b.state for b in backs] == [BACKING, BACKING]
    assert [b.command.x for b in backs] == pytest.approx([-0.15, -0.3])
    stood = watched(sjmc(), walker, FAR, num=30)
    never = make_method(replace(CONFIG, sjmc=replace(SJMC, backs_off_m=0.0)))
    told = watched(never, walker, FAR, velocity=slowly, num=30)
    assert (stood.state, told.state) == (WAITING, WAITING)
    assert stood.command == told.command == STILL


@pytest.mark.parametrize("fastest", [0.1, 0.2, 0.8])
def test_it_backs_no_faster_than_it_travels(fastest: float) -> None:
    """The same walker before a slow robot; both ends of the range come from the same scene."""
    config = replace(CONFIG, robot=replace(ROBOT, speed_m_s=fastest))
    walker, slowly = [(0.75, 0.9, 0.2, -0.3, -0.8)], Velocity(0.1, 0.0, 0.0)
    decision = watched(make_method(config), walker, FAR, velocity=slowly, num=30)
    assert decision.state == BACKING and -fastest <= decision.command.x < 0.0
    assert decision.command.yaw_rate == 0.0


def test_who_sees_nothing_at_all_stands_and_does_not_back_either() -> None:
    method, scan, speeds = sjmc(), scan_of([]), []
    for k in range(100):
        velocity = Velocity(0.4, 0.0, 0.0) if k < 30 else STILL
        seen = scan if k < 30 else replace(scan, ranges=np.full_like(scan.ranges, np.nan))
        state = RobotState(velocity, velocity, moved_by(velocity, PERIOD))
        speeds.append(method.decide(state, Obstacles(seen, SE2.identity()), FAR).command.x)
    assert max(speeds[:30]) > 0.0 and set(speeds[31:]) == {0.0}


def test_debug_names_the_courses_and_the_one_taken() -> None:
    debug = watched(sjmc(), [(2.4, 0.1, 0.5)], FAR, has_debug=True).debug
    assert debug is not None and len(debug.candidates) == len(debug.times)
    assert debug.times[0] < debug.times.max() and 0 <= debug.chosen < len(debug.times)
    assert np.abs(debug.grown[:, 1]).max() == pytest.approx(HALF)


def test_debug_names_the_person_who_sets_the_speed() -> None:
    aside, ahead = (2.0, 2.5, 0.2), (2.5, 0.1, 0.2)
    debug = watched(sjmc(), [aside, ahead], FAR, has_debug=True).debug
    assert debug is not None and len(debug.people) == 2
    assert debug.people[debug.who, :2] == pytest.approx(ahead[:2], abs=0.15)
    alone = watched(sjmc(), [aside], FAR, has_debug=True).debug
    assert alone is not None and len(alone.people) == 1 and alone.who == -1


def test_patience_with_one_person_ends() -> None:
    """Somebody who paces in the way is waited for, then taken as in the way for good."""
    method, states = sjmc(), []
    for k in range(round(6.0 / PERIOD)):
        y = 0.25 * math.sin(2.0 * math.pi * k * PERIOD / 2.5)
        states.append(watched(method, [(1.15, y, 0.2)], FAR, num=1).state)
    assert WAITING in states and states[-1] != WAITING
