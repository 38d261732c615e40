"""A range finder that repeats itself."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from floornav_common.stuck_scan import StuckScan

HERE = SE2(1.0, 2.0, 0.3)
AHEAD = HERE @ SE2(0.06, 0.0, 0.0)
TURNED = HERE @ SE2(0.0, 0.0, 0.06)
RANGES = np.linspace(1.0, 3.0, 20)


@pytest.mark.parametrize("there", [AHEAD, TURNED])
def test_the_same_ranges_from_another_place_are_refused(there: SE2) -> None:
    stuck = StuckScan()
    stuck.take(RANGES, HERE)
    stuck.take(RANGES, there)
    assert "stuck" in stuck.fault


def test_small_steps_add_up() -> None:
    stuck, pose = StuckScan(), HERE
    for _ in range(5):
        stuck.take(RANGES, pose)
        assert not stuck.fault
        pose = pose @ SE2(0.0121, 0.0, 0.0)
    stuck.take(RANGES, pose)
    assert "0.06 m" in stuck.fault


def test_a_robot_that_stands_may_see_the_same_for_ever() -> None:
    stuck = StuckScan()
    for _ in range(50):
        stuck.take(RANGES, HERE)
        assert not stuck.fault


def test_one_other_range_is_a_new_scan() -> None:
    stuck, other = StuckScan(), RANGES.copy()
    other[7] += 1e-3
    for ranges, place in ((RANGES, HERE), (other, AHEAD), (RANGES, HERE)):
        stuck.take(ranges, place)
        assert not stuck.fault


def test_beams_that_were_not_seen_are_the_same_too() -> None:
    stuck, holed = StuckScan(), np.where(np.arange(20) % 3, RANGES, np.nan)
    stuck.take(holed, HERE)
    stuck.take(holed, AHEAD)
    assert "stuck" in stuck.fault


def test_open_space_looks_the_same_from_everywhere() -> None:
    stuck, open_space = StuckScan(), np.full(20, np.inf)
    open_space[:3] = 0.5  # three of twenty: the robot's own mast
    stuck.take(open_space, HERE)
    stuck.take(open_space, AHEAD)
    assert not stuck.fault


def test_it_is_no_longer_stuck_once_a_range_changes() -> None:
    stuck = StuckScan()
    stuck.take(RANGES, HERE)
    stuck.take(RANGES, AHEAD)
    assert stuck.fault
    stuck.take(RANGES + 0.01, AHEAD)
    assert not stuck.fault
