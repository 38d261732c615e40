"""Where on a path to head for."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sjmc_planner.path_target import PathTarget

CORNER = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])


def test_it_heads_for_a_point_ahead_of_the_nearest_one():
    goal = PathTarget(CORNER, 0.5).goal(SE2(0.5, 0.2, 0.0))
    assert goal.point == pytest.approx([0.5, -0.2])
    assert goal.distance == pytest.approx(3.5)


def test_round_a_corner_the_point_is_on_the_next_leg():
    target = PathTarget(CORNER, 0.5)
    target.goal(SE2(1.0, 0.0, 0.0))
    goal = target.goal(SE2(1.8, 0.0, np.pi / 2))
    assert goal.point == pytest.approx([0.3, -0.2], abs=1e-9)


def test_at_the_end_what_is_left_is_the_straight_distance():
    target = PathTarget(CORNER, 0.5)
    for y in (0.0, 0.8, 1.6, 1.9):
        goal = target.goal(SE2(2.0, y, 0.0))
    assert goal.point == pytest.approx([0.0, 0.1]) and goal.distance == pytest.approx(0.1)


def test_a_crossing_is_no_short_cut():
    loop = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0], [2.0, -2.0]])
    target = PathTarget(loop, 0.3)
    for x in (0.5, 1.0, 1.5, 2.0):
        goal = target.goal(SE2(x, 0.0, 0.0))
    assert goal.point == pytest.approx([0.3, 0.0])


def test_progress_never_runs_back():
    target = PathTarget(CORNER, 0.5)
    target.goal(SE2(1.0, 0.0, 0.0))
    assert target.goal(SE2(0.2, 0.0, 0.0)).point == pytest.approx([1.3, 0.0])


def test_a_single_point_is_a_goal():
    goal = PathTarget(np.array([[3.0, 4.0]]), 0.5).goal(SE2.identity())
    assert goal.point == pytest.approx([3.0, 4.0]) and goal.distance == pytest.approx(5.0)
    assert goal.bearing == pytest.approx(np.arctan2(4.0, 3.0))


def test_points_that_repeat_do_no_harm():
    path = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    assert PathTarget(path, 0.4).goal(SE2.identity()).point == pytest.approx([0.4, 0.0])


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.zeros((2, 3)), np.array([[np.nan, 0.0]])])
def test_no_path_is_refused(points):
    with pytest.raises(ValueError, match="points must be"):
        PathTarget(points, 0.5)
