"""The cells around the robot: how certain they get, and that they stay where they are."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.certainty_window import CertaintyWindow
from sjmc_planner.planning import Obstacles

NUM = 360
STILL = SE2(0.0, 0.0, 0.0)


def ends_of(point, pose=STILL, far=np.inf):
    """Return what a full circle of beams sees of one point of the world."""
    step = 2.0 * np.pi / NUM
    ranges = np.full(NUM, far)
    if point is not None:
        x, y = (pose.inverse() @ np.array([point], dtype=float))[0]
        ranges[round((np.arctan2(y, x) + np.pi) / step) % NUM] = np.hypot(x, y)
    return BeamReader(0.0).read(Obstacles(Scan(ranges, -np.pi, step, 0.05, 6.0), STILL))


def window(**kwargs) -> CertaintyWindow:
    return CertaintyWindow(**{"radius": 2.0, "cell": 0.1, "hit_gain": 3, "miss_loss": 1, **kwargs})


def test_certainty_rises_by_hits_to_15_and_falls_where_beams_see_past():
    """The published 3 and 1: five hits, fifteen misses."""
    made, sees, past = window(), ends_of((1.0, 0.0)), ends_of(None)
    rising = [made.update(sees, STILL).certainty[0] * 15 for _ in range(6)]
    assert rising == pytest.approx([3, 6, 9, 12, 15, 15])
    falling = [len(made.update(past, STILL).points) for _ in range(15)]
    assert falling == [1] * 14 + [0]


def test_a_cell_stands_at_its_middle():
    cells = window().update(ends_of((1.04, 0.0)), STILL)
    assert cells.points == pytest.approx(np.array([[1.0, 0.0]]))


def test_what_hides_behind_another_thing_stays():
    made = window(hit_gain=15, miss_loss=15)
    made.update(ends_of((1.5, 0.0)), STILL)
    assert len(made.update(ends_of((1.0, 0.0)), STILL).points) == 2


def test_what_was_not_looked_at_stays():
    made = window(hit_gain=15, miss_loss=15)
    made.update(ends_of((1.5, 0.0)), STILL)
    assert len(made.update(ends_of(None, far=np.nan), STILL).points) == 1


def test_cells_stay_on_the_floor_while_the_robot_drives_and_turns():
    made = window(hit_gain=15, miss_loss=1)
    made.update(ends_of((1.0, 0.5)), STILL)
    unseen = ends_of(None, far=np.nan)
    moved = SE2(0.05, 0.01, 0.1)
    pose = STILL
    for _ in range(10):
        pose = pose @ moved
        cells = made.update(unseen, moved)
    assert cells.points == pytest.approx(pose.inverse() @ np.array([[1.0, 0.5]]), abs=1e-9)


def test_cells_that_leave_the_window_are_forgotten_also_when_the_robot_comes_back():
    made = window(hit_gain=15)
    made.update(ends_of((-1.5, 0.0)), STILL)
    unseen = ends_of(None, far=np.nan)
    assert len(made.update(unseen, SE2(0.4, 0.0, 0.0)).points) == 1
    assert len(made.update(unseen, SE2(0.4, 0.0, 0.0)).points) == 0
    assert len(made.update(unseen, SE2(-0.8, 0.0, 0.0)).points) == 0


def test_a_far_drive_never_takes_one_cell_of_the_floor_for_another():
    """The window's memory is used again and again; after 10 m only what is near is there."""
    made, pose = window(hit_gain=15), STILL
    for _ in range(100):
        step = SE2(0.1, 0.0, 0.0)
        pose = pose @ step
        cells = made.update(ends_of((5.0, 0.3), pose) if pose.x < 5.0 else ends_of(None), step)
    assert len(cells.points) == 0
