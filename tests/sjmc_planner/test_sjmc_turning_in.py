"""How fast to meet who comes beside the way: by hand, and by letting them turn in."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sjmc_scenes import CONFIG, ROBOT, goal_at, people_scene, watched

from sjmc_planner.methods import make_method
from sjmc_planner.planning import Velocity
from sjmc_planner.sjmc_turning_in import (
    speed_to_rest_before,
    speed_to_rest_by,
    time_to_turn_in,
    turning_in_bound,
)

FRONT, REAR, HALF, BODY = 0.2, 0.5, 0.3, 0.25
AIR, REACH, BRAKE, DELAY, TURN_S = 0.2, 4.0, 0.8, 0.15, 0.5
LATE = 0.15  # until a turn is known, s
MIDDLE = 0.5 * (FRONT - REAR)
REST = 0.05  # m/s
FAR = goal_at(12.0, 0.0)


def bound_of(*people: tuple[float, float, float, float], course: float = 0.0, turn: float = TURN_S):
    args = FRONT, REAR, HALF, AIR, REACH, BRAKE, DELAY, turn
    return turning_in_bound(course, people_scene(*people), *args)


def test_the_time_to_turn_in_by_hand() -> None:
    """1 m at 2 m/s^2; 2 m going away at 1 m/s: 2 + t - t^2 = 0; who is in D is there at once."""
    assert time_to_turn_in(1.0, 0.0, 2.0) == pytest.approx(1.0)
    assert time_to_turn_in(2.0, 1.0, 2.0) == pytest.approx(2.0)
    assert time_to_turn_in(2.0, -1.0, 2.0) == pytest.approx(1.0)
    assert time_to_turn_in(-0.1, 3.0, 2.0) == 0.0


def test_the_speed_to_be_at_rest_by_hand() -> None:
    """From 0.8 m/s it stands after 0.15 + 1 s, 0.12 + 0.4 m on; at 1.4 m/s the other comes 1.61 m.

    Less 0.04 m/s, which is as good as standing.
    """
    assert speed_to_rest_by(1.1, BRAKE, DELAY) == pytest.approx(0.8)
    assert speed_to_rest_by(0.0, BRAKE, DELAY) == 0.0
    assert speed_to_rest_before(0.52 + 1.61, 1.4, BRAKE, DELAY) == pytest.approx(0.8)
    assert speed_to_rest_before(1.4 * DELAY, 1.4, BRAKE, DELAY) == 0.0


def test_who_comes_beside_the_way_is_met_at_the_later_of_both() -> None:
    """0.1 m beside D it could turn in at once, but is level only later.

    From 0.8 m/s the robot stands after 0.3 + 1 s, 0.24 + 0.4 m on; the other comes 1.82 m.
    """
    x, y = FRONT + BODY + AIR + 0.64 + 1.82, HALF + BODY + 0.1
    assert bound_of((x, y, -1.4, 0.0)) == (pytest.approx(0.8), 0)
    near = bound_of((FRONT + BODY + AIR, y + 0.26, -1.0, 0.0))  # level; 0.36 m at 2 m/s^2: 0.6 s
    assert near == (pytest.approx(BRAKE * 0.3 + 0.04), 0)


def test_who_goes_ahead_may_halt_and_who_is_past_or_stands_is_not_minded() -> None:
    """Going at 1 m/s it halts within 0.25 m; 0.24 + 0.4 m on the robot stands from 0.8 m/s."""
    x = FRONT + BODY + AIR + 0.64
    assert bound_of((x - 0.25, 0.0, 1.0, 0.0))[0] == pytest.approx(0.8)
    for person in ((1.0, 2.2, -1.4, 0.0), (-0.5, 0.7, 0.3, 0.0), (1.0, 0.3, 0.0, 0.0)):
        assert bound_of(person) == (math.inf, -1)
    assert bound_of((1.0, 0.0, -1.4, 0.0), turn=0.0) == (math.inf, -1)


@given(
    x=st.floats(0.5, 4.0), y=st.floats(-2.5, 2.5), vx=st.floats(-2.0, 0.0),
    vy=st.floats(-1.0, 1.0), waits=st.floats(0.0, 1.0), share=st.floats(0.0, 1.0),
)  # fmt: skip
def test_whoever_turns_in_whenever_meets_a_robot_at_rest(
    x: float, y: float, vx: float, vy: float, waits: float, share: float
) -> None:
    bound = min(bound_of((x, y, vx, vy))[0], 2.0)
    in_way, dt = math.copysign(1.0, y), 0.005
    speed, driven, t = bound, 0.0, 0.0
    turn = share * math.hypot(vx, vy) / TURN_S if math.hypot(vx, vy) > 0.1 else 0.0
    while speed > REST and turn > 0.0:
        is_aside = abs(y) - BODY > HALF
        is_level = x - BODY < FRONT + driven and x + BODY > MIDDLE + driven
        assert is_aside or not is_level
        vy -= in_way * (turn * dt if t >= waits else 0.0)
        x, y, t = x + vx * dt, y + vy * dt, t + dt
        speed -= BRAKE * dt if t > DELAY + LATE else 0.0
        driven += speed * dt


@given(y=st.floats(-2.0, 2.0), vy=st.floats(-1.0, 1.0), course=st.floats(-0.5, 0.5))
def test_a_mirrored_person_allows_the_same(y: float, vy: float, course: float) -> None:
    left = bound_of((2.0, y, -1.2, vy), (1.0, 1.0, 0.2, -0.5), course=course)
    right = bound_of((2.0, -y, -1.2, -vy), (1.0, -1.0, 0.2, 0.5), course=-course)
    assert left == right


def test_it_is_slower_beside_who_comes_and_goes_straight_on() -> None:
    """Passing 0.7 m beside its middle at 1.2 m/s: foreseen to pass, but near enough to turn in."""
    walker, drives = [(1.7, 0.75, 0.2, -1.2, 0.0)], Velocity(0.6, 0.0, 0.0)
    never = make_method(replace(CONFIG, sjmc=replace(CONFIG.sjmc, turns_in_s=0.0)))
    free = watched(never, walker, FAR, velocity=drives)
    minds = watched(make_method(CONFIG), walker, FAR, velocity=drives)
    assert free.command.x == pytest.approx(ROBOT.speed_m_s)
    assert minds.command.x < 0.75 * free.command.x and minds.reason == "slower for a person"
    assert abs(minds.command.yaw_rate) < 1e-6
