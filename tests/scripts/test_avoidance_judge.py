"""What the avoidance experiment says of a drive, on drives made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.avoidance_fields import ROBOT_RADIUS, Field
from experiments.avoidance_judge import Judge, Run, figures, turns
from floornav_common.se2 import SE2

FIELD = Field("by hand", (0.0, 0.0), (2.0, 0.0), np.zeros((0, 3)))
DT, SPEED = 0.01, 0.4


class Disk:
    """A post at (1, y)."""

    def __init__(self, y: float, radius: float = 0.1) -> None:
        self._place, self._radius = np.array([1.0, y]), radius

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        return np.hypot(*(points - self._place).T) - self._radius


def driven(post: Disk, turn_at: float = np.inf, seconds: float = 5.0, touch_at: float = np.inf):
    """Return the judge of a drive along x at 0.4 m/s that moves 6 degrees aside from a time on."""
    judge = Judge(FIELD, [post])
    for k in range(1, round(seconds / DT) + 1):
        t = k * DT
        aside = np.tan(np.radians(6.0)) * SPEED if t >= turn_at - 1e-9 else 0.0
        judge.note(t, SE2(SPEED * t, 0.0, 0.0), (SPEED, aside), t >= touch_at - 1e-9)
    return judge


def test_time_way_and_clearance_of_a_straight_drive():
    run = driven(Disk(0.5)).result(True)
    assert run.is_reached and not run.has_collided
    assert (run.time_s, run.path_m) == pytest.approx((5.0, 2.0))
    assert run.min_clearance_m == pytest.approx(0.5 - 0.1 - ROBOT_RADIUS)
    assert run.turn_start_s is None
    assert run.track[1] == pytest.approx((0.4 / 3.0, 0.0), abs=0.005) and len(run.track) == 15


def test_a_drive_into_a_post_ends_at_its_edge():
    """The post's edge is 0.9 m ahead, the robot's 0.085 m before its middle."""
    run = driven(Disk(0.0), turn_at=3.0).result(True)
    assert run.has_collided and not run.is_reached
    assert run.path_m == pytest.approx(0.9 - ROBOT_RADIUS, abs=SPEED * DT)
    assert run.time_s == pytest.approx(run.path_m / SPEED)
    assert run.turn_start_s is None  # that came after the end


def test_a_touch_that_the_simulation_felt_counts_however_far_the_solids_are():
    run = driven(Disk(5.0), touch_at=5.0).result(True)
    assert run.has_collided and not run.is_reached


def test_the_turn_begins_at_the_first_step_that_is_five_degrees_off_the_goal():
    assert driven(Disk(0.5), turn_at=1.5).result(True).turn_start_s == pytest.approx(1.5)


def test_the_robot_s_own_heading_counts_for_the_turn():
    judge = Judge(FIELD, [Disk(0.5)])
    judge.note(0.01, SE2(0.0, 0.0, np.pi / 2), (0.0, -0.4), False)  # to the goal, sideways
    judge.note(0.02, SE2(0.0, 0.0, np.pi / 2), (0.01, 0.0), False)  # hardly moving
    assert judge.result(False).turn_start_s is None
    judge.note(0.03, SE2(0.0, 0.0, np.pi / 2), (0.4, 0.0), False)
    assert judge.result(False).turn_start_s == 0.03


def test_a_robot_that_stays_gives_up_after_six_seconds():
    judge = Judge(FIELD, [Disk(0.5)])
    for k in range(1, 7):
        judge.note(float(k), SE2(0.3 * min(k, 2), 0.0, 0.0), (0.0, 0.0), False)
    assert not judge.has_given_up
    judge.note(8.5, SE2(0.62, 0.0, 0.0), (0.0, 0.0), False)  # 2 cm are no progress
    assert judge.has_given_up


def run_with(turn: float | None, reached: bool = True, collided: bool = False) -> Run:
    empty = np.zeros((1, 2))
    return Run(FIELD, reached, collided, 8.0 if reached else 3.0, 2.0, 0.1, turn, empty, empty)


def test_leads_are_counted_by_their_sign_and_only_where_both_turned():
    pairs = [(1.0, 1.5), (1.0, 1.2), (2.0, 1.0), (1.0, 1.0), (None, 1.0), (1.0, None)]
    found = turns([(run_with(a), run_with(b)) for a, b in pairs])
    assert (found["fields"], found["earlier"], found["later"]) == (4, 2, 1)
    assert found["mean_lead_s"] == pytest.approx(-0.075)
    assert turns([])["mean_lead_s"] is None


def test_times_are_of_those_that_got_there_and_collisions_of_all():
    runs = [run_with(1.0), run_with(None, reached=False, collided=True), run_with(3.0)]
    found = figures(runs)
    assert (found["runs"], found["reached"], found["collisions"]) == (3, 2, 1)
    assert (found["time_s"], found["turn_start_s"]) == (8.0, 2.0)
    assert figures([])["time_s"] is None and figures([])["min_clearance_m"] is None
