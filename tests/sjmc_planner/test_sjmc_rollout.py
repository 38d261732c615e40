"""What is foreseen of a command."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.planning import STILL, Velocity
from sjmc_planner.sjmc_region import box_of
from sjmc_planner.sjmc_rollout import Foresight

ROBOT = RobotConfig(
    drive="differential", radius_m=0.6, front_m=0.2, rear_m=0.5, half_width_m=0.3, speed_m_s=0.8,
    accel_m_s2=0.8, yaw_rate_rad_s=1.2, yaw_accel_rad_s2=2.5,
)  # fmt: skip
NOTHING, NOBODY = np.zeros((0, 2)), np.zeros((0, 5))
DELAY, UNTIL, TOL_M = 0.2, 2.5, 0.02
STEP_M = 0.05  # half of what the front, or a corner, goes on in a step of 0.1 s


def foresight(robot: RobotConfig = ROBOT) -> Foresight:
    return Foresight(robot, box_of(robot), DELAY, UNTIL)


def test_braking_takes_the_way_of_the_delay_and_of_the_limit() -> None:
    """0.8 m/s: 0.16 m in 0.2 s, then 0.4 m; a wall 1 m before the front is left at 0.44 m."""
    wall = np.array([[1.2, 0.0]])
    seen = foresight().look(Velocity(0.8, 0.0, 0.0), 0.0, 0.0, 0.0, wall, NOBODY)
    assert seen.thing_gap == pytest.approx(0.44, abs=TOL_M)


def test_nothing_is_infinitely_far() -> None:
    seen = foresight().look(STILL, 0.0, 0.8, 1.0, NOTHING, NOBODY)
    assert seen.thing_gap == seen.people_gap == math.inf


def test_who_walks_past_a_standing_robot_is_nearest_abreast_of_it() -> None:
    """From 1 m ahead at 1 m/s along y = 1: 0.7 - 0.25 m beside it from 0.8 s on."""
    person = np.array([[1.0, 1.0, -1.0, 0.0, 0.25]])
    seen = foresight().look(STILL, 0.0, 0.0, 0.0, NOTHING, person)
    assert seen.people_gap == pytest.approx(0.45, abs=1e-6)
    assert seen.people_time == pytest.approx(0.8, abs=0.11)


def test_backing_makes_room() -> None:
    person = np.array([[1.2, 1.5, 0.0, -1.0, 0.25]])
    stands = foresight().look(STILL, 0.0, 0.0, 0.0, NOTHING, person)
    backs = foresight().obey(STILL, Velocity(-0.5, 0.0, 0.0), 2.0, NOTHING, person)
    assert backs.people_gap > stands.people_gap + 0.15


def test_who_walks_through_the_robot_is_the_deeper_in_the_less_it_backs() -> None:
    """0.1 m behind the front on the middle line: 0.1 m deep and the radius; half the width most."""
    crosses = np.array([[0.1, 1.0, 0.0, -1.0, 0.25]])
    stands = foresight().look(STILL, 0.0, 0.0, 0.0, NOTHING, crosses)
    assert stands.people_gap == pytest.approx(-0.1 - 0.25, abs=1e-6)
    backs = foresight().obey(STILL, Velocity(-0.15, 0.0, 0.0), 2.0, NOTHING, crosses)
    assert backs.people_gap > stands.people_gap + 0.02


def test_a_thing_beside_is_swept_by_the_tail_of_a_turn() -> None:
    thing = np.array([[-0.3, -0.35]])
    seen = foresight().look(STILL, math.radians(90.0), 0.0, 2.0, thing, NOBODY)
    assert seen.thing_gap == pytest.approx(0.0, abs=0.01)


@settings(max_examples=60)
@given(
    x=st.floats(0.0, 0.8), w=st.floats(-1.2, 1.2), px=st.floats(-1.0, 2.0), py=st.floats(-1.2, 1.2)
)
def test_what_a_turning_robot_really_sweeps_until_it_stands_is_foreseen(
    x: float, w: float, px: float, py: float
) -> None:
    """Driven in steps of 5 ms: on as it is for the delay, then braking at both limits."""
    point, box, dt = np.array([[px, py]]), box_of(ROBOT), 0.005
    pose, now, real = SE2.identity(), Velocity(x, 0.0, w), math.inf
    for k in range(round(UNTIL / dt)):
        there = (pose.inverse() @ point)[0]
        ahead = max(there[0] - box.front, -box.rear - there[0], 0.0)
        real = min(real, math.hypot(ahead, max(abs(there[1]) - box.half_width, 0.0)))
        now = now if k * dt < DELAY else ramped(now, STILL, ROBOT, dt)
        pose = pose @ moved_by(now, dt)
    seen = foresight().look(Velocity(x, 0.0, w), 0.0, 0.0, 0.0, point, NOBODY)
    assert seen.thing_gap == pytest.approx(real, abs=STEP_M)


@settings(max_examples=60)
@given(
    back=st.floats(-0.5, 0.0), w=st.floats(-1.2, 1.2), px=st.floats(-1.5, 0.8),
    py=st.floats(-1.2, 1.2),
)  # fmt: skip
def test_what_an_arc_back_really_sweeps_is_foreseen(
    back: float, w: float, px: float, py: float
) -> None:
    """Driven in steps of 5 ms: at rest for the delay, the arc for 1 s, then braking."""
    point, box, dt, hold = np.array([[px, py]]), box_of(ROBOT), 0.005, 1.0
    pose, now, real, command = SE2.identity(), STILL, math.inf, Velocity(back, 0.0, w)
    for k in range(round(UNTIL / dt)):
        there = (pose.inverse() @ point)[0]
        ahead = max(there[0] - box.front, -box.rear - there[0], 0.0)
        real = min(real, math.hypot(ahead, max(abs(there[1]) - box.half_width, 0.0)))
        is_held = DELAY <= k * dt < DELAY + hold
        now = ramped(now, command if is_held else STILL, ROBOT, dt)
        pose = pose @ moved_by(now, dt)
    seen = foresight().obey(STILL, command, hold, point, NOBODY)
    assert seen.thing_gap == pytest.approx(real, abs=STEP_M)


def test_a_holonomic_robot_obeys_along_the_course_of_the_command() -> None:
    """Back at 0.3 m/s for 1 s: 0.3 m and no more than a step, of the 0.5 m to the thing."""
    omni = RobotConfig(radius_m=0.3, speed_m_s=0.8, accel_m_s2=8.0)
    thing = np.array([[-0.8, 0.0]])
    seen = foresight(omni).obey(STILL, Velocity(-0.3, 0.0, 0.0), 1.0, thing, NOBODY)
    assert seen.thing_gap == pytest.approx(0.2, abs=STEP_M)


def test_a_robot_without_a_box_is_its_circle() -> None:
    circle = RobotConfig(radius_m=0.3, accel_m_s2=0.8)
    seen = foresight(circle).look(STILL, 0.0, 0.0, 0.0, np.array([[0.3, 0.4]]), NOBODY)
    assert seen.thing_gap == pytest.approx(0.2)


def test_a_mirrored_scene_is_foreseen_the_same() -> None:
    rng = np.random.default_rng(0)
    things, people = rng.uniform(-2.0, 3.0, (20, 2)), rng.uniform(-2.0, 2.0, (4, 5))
    now = Velocity(0.5, 0.0, 0.3)
    seen = foresight().look(now, 0.4, 0.6, 0.5, things, people)
    flip, flip_people = np.array([1.0, -1.0]), np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    mirrored = Velocity(0.5, 0.0, -0.3)
    assert seen == foresight().look(mirrored, -0.4, 0.6, 0.5, things * flip, people * flip_people)


def test_what_is_left_out_could_not_have_been_met() -> None:
    """Leaving out what is far changes nothing that is nearer than what is kept clear of."""
    rng, sight = np.random.default_rng(1), foresight()
    for _ in range(30):
        now = Velocity(float(rng.uniform(0.0, 0.8)), 0.0, float(rng.uniform(-1.0, 1.0)))
        things = rng.uniform(-4.0, 4.0, (60, 2))
        people = np.column_stack((rng.uniform(-6.0, 6.0, (8, 2)), rng.uniform(-1.5, 1.5, (8, 2)),
                                  np.full(8, 0.25)))  # fmt: skip
        near = sight.within_reach(now, 0.8, things)
        met = sight.may_meet(now, 0.8, people)
        course = float(rng.uniform(-2.0, 2.0))
        whole = sight.look(now, course, 0.8, 0.05, things, people)
        part = sight.look(now, course, 0.8, 0.05, near, met)
        assert min(part.thing_gap, 0.4) == pytest.approx(min(whole.thing_gap, 0.4))
        assert min(part.people_gap, 0.3) == pytest.approx(min(whole.people_gap, 0.3))


@pytest.mark.parametrize(
    ("gaps", "kept"),
    [
        ((0.5, 0.9), (0.1, 0.1)),  # the margin
        ((0.07, 0.5), (0.07, 0.07)),  # along what it stands beside
        ((0.02, 0.04, 0.5), (0.02, 0.04, 0.05)),  # no nearer, and half of the margin off the rest
        ((0.0, 0.5), (0.0, 0.05)),  # nothing is in the robot
    ],
)
def test_what_is_kept_off_things(gaps: tuple[float, ...], kept: tuple[float, ...]) -> None:
    things = np.array([[0.2 + gap, 0.0] for gap in gaps])
    rows = foresight().kept_off(things, 0.1)
    assert rows[:, :2] == pytest.approx(things) and rows[:, 2] == pytest.approx(kept, abs=1e-5)
    seen = foresight().look(STILL, 0.0, 0.0, 0.0, rows, NOBODY)
    assert 0.0 < seen.thing_gap == pytest.approx(min(np.subtract(gaps, kept)), abs=1e-5)
