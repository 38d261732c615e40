"""How well people are followed, on looks made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.tracking_drives import Look
from experiments.tracking_judge import TrackingJudge
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.obstacle_state import Tracks

PERIOD_S = 0.1


def look(time_s: float, x: float, vx: float, is_slipping: bool = False) -> Look:
    """Return a look at one person on the robot's x axis, who is met by 10 beams."""
    ranges = np.full(180, np.inf)
    ranges[85:95] = x - 0.2
    scan = Scan(ranges, np.radians(-90.0), np.radians(1.0), 0.1, 8.0)
    people = np.array([[x, 0.0, vx, 0.0]])
    here = SE2.identity()
    return Look(time_s, scan, here, here, here, people, ("somebody",), is_slipping)


def track(x: float, vx: float, number: int = 1, age: float = 5.0, unseen: float = 0.0) -> Tracks:
    one = np.ones(1)
    return Tracks(
        np.array([number]), np.array([[x, 0.0]]), np.array([[vx, 0.0]]), 0.01 * np.eye(4)[None],
        0.25 * one, age * one, unseen * one, one, np.full(180, -1),
    )  # fmt: skip


def judged(*steps: tuple[Look, Tracks]) -> dict[str, float | None]:
    judge = TrackingJudge()
    for seen, tracks in steps:
        judge.note(seen, tracks)
    return judge.figures()


def test_errors_of_a_walker_by_hand() -> None:
    steps = [(look(0.1 * k, 2.0, 1.0), track(2.1, 0.8)) for k in range(11)]
    found = judged(*steps)
    assert found["followed"] == 1.0
    assert found["velocity_error_m_s"] == pytest.approx(0.2)
    assert found["place_error_m"] == pytest.approx(0.1)
    assert found["nees_mean"] == pytest.approx((0.1**2 + 0.2**2) / 0.01)
    assert found["switches_per_person_minute"] == 0.0
    assert found["false_movers_per_minute"] == 0.0


def test_a_velocity_is_known_from_when_its_error_is_small() -> None:
    steps = [(look(0.1 * k, 2.0, 1.0), track(2.0, 0.17 * k)) for k in range(8)]
    assert judged(*steps)["first_velocity_s"] == pytest.approx(0.4)  # 0.68 m/s of 1


def test_another_number_is_a_switch_unless_it_was_long_ago() -> None:
    soon = [(look(0.0, 2.0, 1.0), track(2.0, 1.0, 1)), (look(0.1, 2.0, 1.0), track(2.0, 1.0, 2))]
    late = [soon[0], (look(1.5, 2.0, 1.0), track(2.0, 1.0, 2))]
    # Two looks at one person, 0.1 s each.
    assert judged(*soon)["switches_per_person_minute"] == pytest.approx(1.0 / (0.2 / 60.0))
    assert judged(*late)["switches_per_person_minute"] == 0.0


def test_who_is_not_near_a_track_is_not_followed() -> None:
    found = judged(*[(look(0.1 * k, 2.0, 1.0), track(2.7, 1.0)) for k in range(3)])
    assert found["followed"] == 0.0
    assert found["velocity_error_m_s"] is None


def test_a_mover_where_nobody_is_is_false_once_however_long() -> None:
    steps = [(look(0.1 * k, 2.0, 0.0), track(4.0, 0.5)) for k in range(61)]
    assert judged(*steps)["false_movers_per_minute"] == pytest.approx(10.0)  # one in 6 s
    hidden = [(seen, track(4.0, 0.5, unseen=0.3)) for seen, _ in steps]
    assert judged(*hidden)["false_movers_per_minute"] == 0.0


def test_nothing_is_judged_while_odometry_is_wrong_and_two_seconds_after() -> None:
    steps = [(look(0.0, 2.0, 1.0, True), track(9.0, 3.0))]
    steps += [(look(0.1 * k, 2.0, 1.0), track(9.0, 3.0)) for k in range(1, 20)]
    found = judged(*steps)
    assert found["followed"] is None
    assert found["false_movers_per_minute"] is None
