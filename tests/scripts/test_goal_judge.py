"""experiments/goal_judge.py: touches, stops and what was touched, from a record alone."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("sim_bridge.solids")

from experiments.goal_judge import Surroundings, judge, long_stops, touched
from experiments.goal_record import GoalRecord
from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.solids import Solid

OUTLINE = np.array([[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]])
TORSO_M = 0.2
STEP_NS = 20_000_000
NOBODY = np.zeros((0, 2))


def pane(x: float) -> Solid:
    return Solid(
        "pane", SE2(x, 0.0, np.pi / 2), (2.0, 0.01, 2.0), 0.0, False, (1.0,) * 3, glass=Glass()
    )


def box(x: float) -> Solid:
    return Solid("chest", SE2(x, 0.0, 0.0), (0.4, 2.0, 1.0), 0.0, False, (0.5,) * 3)


def around(*solids: Solid) -> Surroundings:
    return Surroundings(OUTLINE, solids, TORSO_M)


def drive(*speeds_and_times: tuple[float, float]) -> GoalRecord:
    """Return a drive along x with these speeds, m/s, for these times, s."""
    record, x = GoalRecord(num_goals=2), 0.0
    for speed, seconds in speeds_and_times:
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            x += speed * STEP_NS * 1e-9
            record.truth.append(((len(record.truth) + 1) * STEP_NS, SE2(x, 0.0, 0.0)))
    return record


def test_a_stop_of_six_seconds_on_the_way_counts_and_one_of_four_does_not() -> None:
    record = drive((0.5, 2.0), (0.0, 4.0), (0.5, 2.0), (0.0, 6.0), (0.5, 1.0))
    ((begin, end),) = long_stops(record)
    assert begin == pytest.approx(8.0, abs=0.3) and end == pytest.approx(14.0, abs=0.3)
    assert judge(record, around())["stopped_s"] == pytest.approx(10.0, abs=0.6)


def test_standing_before_it_sets_out_is_no_stop() -> None:
    assert long_stops(drive((0.0, 9.0), (0.5, 2.0))) == []


def test_standing_until_the_end_is_a_stop() -> None:
    ((_, end),) = long_stops(drive((0.5, 2.0), (0.0, 9.0)))
    assert end == pytest.approx(11.0, abs=0.05)


def test_turning_on_the_spot_is_no_stop() -> None:
    record = drive((0.5, 1.0))
    last = record.truth[-1][1]
    for k in range(400):
        stamp = record.truth[-1][0] + STEP_NS
        record.truth.append((stamp, SE2(last.x, last.y, 0.01 * (k + 1))))
    assert long_stops(record) == []


def test_the_nearest_thing_is_what_was_touched() -> None:
    world = around(pane(0.34), box(-0.52))
    assert touched(SE2(0.0, 0.0, 0.0), NOBODY, world) == "glass"
    assert touched(SE2(-0.02, 0.0, 0.0), NOBODY, around(pane(1.0), box(-0.52))) == "chest"
    assert touched(SE2(0.0, 0.0, 0.0), NOBODY, around(pane(1.0), box(-1.5))) == "something"


def test_a_person_at_the_outline_was_touched_and_one_farther_off_than_a_wall_was_not() -> None:
    beside = np.array([[0.0, 0.2 + TORSO_M + 0.01]])
    assert touched(SE2(0.0, 0.0, 0.0), beside, around(pane(0.34))) == "a person"
    off = np.array([[0.0, 0.2 + TORSO_M + 0.25]])
    assert touched(SE2(0.0, 0.0, 0.0), off, around(pane(0.34))) == "glass"
    assert touched(SE2(0.0, 0.0, 0.0), off, around()) == "a person"  # a leg stepped out


def test_a_touch_that_comes_again_at_once_is_one_and_later_another() -> None:
    record = drive((0.05, 10.0))
    for second, is_on in ((1.0, True), (1.2, False), (1.5, True), (1.6, False), (5.0, True)):
        record.note_touch(round(second * 1e9), is_on)
    found = judge(record, around(pane(0.38), pane(0.42), pane(0.55)))
    assert found["collisions"] == found["glass_touched"] == 2
    assert [touch["time_s"] for touch in found["touched"]] == [1.0, 5.0]


def test_world_and_robot_moved_together_change_nothing() -> None:
    T = SE2(3.0, -1.0, 0.8)
    person = np.array([[0.0, 0.45]])
    moved = Solid("chest", T @ box(0.52).pose, *vars_of(box(0.52)))
    for people in (NOBODY, person):
        before = touched(SE2(0.0, 0.0, 0.0), people, around(box(0.52)))
        assert touched(T, T @ people, around(moved)) == before


def vars_of(solid: Solid) -> tuple[object, ...]:
    return (solid.size, solid.bottom, solid.is_round, solid.color)


def test_a_drive_without_touch_or_stop_has_none() -> None:
    record = drive((0.5, 4.0))
    record.reached_ns += [1_000_000_000, 4_000_000_000]
    found = judge(record, around(box(9.0)))
    assert (found["goals"], found["reached"]) == (2, 2)
    assert found["collisions"] == found["glass_touched"] == found["stops_over_5s"] == 0
    assert found["path_m"] == pytest.approx(2.0, abs=0.02)
    assert found["time_s"] == pytest.approx(4.0)
