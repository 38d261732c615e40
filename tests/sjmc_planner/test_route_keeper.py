"""Ways over maps, their refusals, and when they are made anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sjmc_planner.route_keeper import DONE, IDLE, NO_WAY, ON_ITS_WAY, WAITING, RouteKeeper
from sjmc_planner.wavefront_config import WavefrontConfig
from sjmc_planner.wavefront_plan import CostMap, NoWayError

CONFIG = WavefrontConfig(radius_m=0.2, margin_m=0.05, goal_search_m=0.2)
START, GOAL = np.array([1.03, 2.02]), np.array([7.03, 2.02])  # on no border of cells


def room(wall: tuple[int, int] | None = None, origin=None) -> OccupancyMap:
    """Return a room of 8 x 4 m; a wall across it at x = 4 m from one row to another."""
    cells = np.zeros((40, 80), dtype=np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    if wall is not None:
        cells[wall[0] : wall[1], 40] = 100
    return OccupancyMap(cells, 0.1, SE2(0.0, 0.0, 0.0) if origin is None else origin)


def keeper(grid=None) -> RouteKeeper:
    made = RouteKeeper(CONFIG)
    made.set_grid(room() if grid is None else grid)
    made.set_goal(GOAL)
    return made


def length(points) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def test_through_an_open_room_the_way_is_straight():
    way = CostMap(room(), CONFIG).plan(START, GOAL)
    assert way.points[0] == pytest.approx(START) and way.points[-1] == pytest.approx(GOAL)
    assert length(way.points) == pytest.approx(6.0, abs=0.05)
    assert np.hypot(*np.diff(way.points, axis=0).T).max() <= CONFIG.spacing_m + 1e-9


def test_around_a_wall_it_keeps_the_robots_size_clear():
    grid = room(wall=(0, 30))
    way = CostMap(grid, CONFIG).plan(START, GOAL)
    end = np.array([4.05, 2.95])  # middle of the wall's last cell
    assert np.hypot(*(way.points - end).T).min() >= 0.25
    assert way.points[np.abs(way.points[:, 0] - 4.05).argmin(), 1] > 3.0


def test_moving_map_robot_and_goal_together_moves_the_way():
    plain = CostMap(room(wall=(0, 30)), CONFIG).plan(START, GOAL).points
    T = SE2(3.0, -2.0, 0.6)
    moved = CostMap(room(wall=(0, 30), origin=T), CONFIG)
    ends = T @ np.stack((START, GOAL))
    assert moved.plan(ends[0], ends[1]).points == pytest.approx(T @ plain, abs=1e-6)


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ((9.0, 2.0), "the goal at (9.00, 2.00) m is outside of the map"),
        ((4.05, 1.0), "inside an obstacle"),
        ((3.85, 1.0), "nearer to an obstacle than the robot's size allows"),
        ((6.0, 2.0), "walled off"),
    ],
)
def test_refusals_name_what_is_wrong(goal, words):
    grid = room(wall=(0, 40))
    strict = replace(CONFIG, goal_search_m=0.0)
    with pytest.raises(NoWayError, match=words.replace("(", r"\(").replace(")", r"\)")):
        CostMap(grid, strict).plan(START, np.array(goal))


def test_a_goal_just_too_near_to_a_wall_is_moved_off_it():
    way = CostMap(room(), CONFIG).plan(START, np.array([7.0, 0.25]))
    assert way.points[-1] == pytest.approx((7.05, 0.35), abs=0.051)


def test_a_robot_too_near_to_a_wall_may_leave_it():
    way = CostMap(room(), CONFIG).plan(np.array([1.0, 0.2]), GOAL)
    assert way.points[0] == pytest.approx((1.0, 0.2)) and way.points[-1] == pytest.approx(GOAL)


def test_where_the_map_is_unknown_it_says_so():
    grid = room()
    cells = grid.cells.copy()
    cells[:, 60:] = -1
    closed = replace(CONFIG, unknown_weight=0.0)
    with pytest.raises(NoWayError, match="where the map is unknown"):
        CostMap(replace(grid, cells=cells), closed).plan(START, GOAL)
    assert len(CostMap(replace(grid, cells=cells), CONFIG).plan(START, GOAL).points)


def test_it_waits_for_a_map_and_then_gives_a_way_once():
    made = RouteKeeper(CONFIG)
    assert made.update(START).state == IDLE
    made.set_goal(GOAL)
    assert made.update(START).state == WAITING
    made.set_grid(room())
    first, second = made.update(START), made.update(START)
    assert first.state == second.state == ON_ITS_WAY
    assert first.points is not None and second.points is None


def test_a_map_that_closes_the_way_gives_another_and_one_that_does_not_gives_none():
    made = keeper()
    before = made.update(START).points
    made.set_grid(room())
    assert made.update(START).points is None
    made.set_grid(room(wall=(0, 30)))
    after = made.update(START).points
    assert after is not None and length(after) > length(before) + 0.5


def test_a_map_that_opens_a_much_shorter_way_gives_it():
    made = keeper(room(wall=(0, 34)))
    assert made.update(START).points is not None
    made.set_grid(room())
    assert length(made.update(START).points) == pytest.approx(6.0, abs=0.05)


def test_a_way_that_closes_altogether_is_taken_back_and_given_again():
    made = keeper()
    made.update(START)
    made.set_grid(room(wall=(0, 40)))
    shut = made.update(START)
    assert shut.state == NO_WAY and shut.points is not None and len(shut.points) == 0
    again = made.update(START)
    assert again.points is None and (again.state, again.text) == (NO_WAY, shut.text)
    made.set_grid(room())
    assert len(made.update(START).points) > 2


def test_off_its_path_it_makes_a_new_one():
    made = keeper()
    made.update(START)
    assert made.update(np.array([2.0, 2.5])).points is None
    points = made.update(np.array([2.0, 3.2])).points
    assert points[0] == pytest.approx((2.0, 3.2))


def test_at_the_goal_it_is_done():
    made = keeper()
    made.update(START)
    assert made.update(GOAL + 0.05).state == DONE
    assert made.update(START).state == IDLE


def test_a_new_goal_takes_the_place_of_the_old_one():
    made = keeper()
    made.update(START)
    made.set_goal(np.array([2.0, 3.0]))
    assert made.update(START).points[-1] == pytest.approx((2.0, 3.0))


def test_a_new_goal_that_cannot_be_reached_takes_the_old_path_back():
    made = keeper()
    made.update(START)
    made.set_goal(np.array([20.0, 3.0]))
    route = made.update(START)
    assert route.state == NO_WAY and len(route.points) == 0


def test_a_new_goal_without_a_pose_takes_the_old_path_back():
    made = keeper()
    made.update(START)
    assert made.wait("pose").points is None  # of the old goal it is kept
    made.set_goal(np.array([2.0, 3.0]))
    assert len(made.wait("pose").points) == 0
