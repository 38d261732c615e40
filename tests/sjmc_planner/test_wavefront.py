"""The wave and the way down it: by hand, and as laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sjmc_planner.travel_costs import travel_costs
from sjmc_planner.wavefront import cut_corners, line_cost, nearest_open, wave, way_down
from sjmc_planner.wavefront_config import WavefrontConfig

FEW = settings(max_examples=40)
CLOSED = math.inf


def grid_of(rows: str) -> np.ndarray:
    """Return weights: `#` closed, a digit its cost, `.` one."""
    lines = rows.split()
    return np.array(
        [[CLOSED if c == "#" else 1.0 if c == "." else float(c) for c in line] for line in lines]
    )


def test_costs_of_an_open_grid_by_hand():
    """From (0, 0): straight 1 a cell, diagonal sqrt 2; (2, 1) is one of each away."""
    cost = wave(grid_of("... ... ..."), 0, 0, -1, -1)
    assert cost[0].tolist() == [0.0, 1.0, 2.0]
    assert cost[1, 1] == pytest.approx(math.sqrt(2.0))
    assert cost[2, 1] == pytest.approx(1.0 + math.sqrt(2.0))


def test_a_wall_is_gone_around_without_cutting_its_corners():
    """Around the end of the wall: down, two to the right, up again."""
    weights = grid_of(".#. ...")
    cost = wave(weights, 0, 0, -1, -1)
    assert cost[0, 2] == 4.0
    cells = way_down(cost, weights, 0, 2)
    assert cells.tolist() == [[0, 2], [1, 2], [1, 1], [1, 0], [0, 0]]


def test_a_step_costs_the_mean_of_its_two_cells():
    cost = wave(grid_of("13."), 0, 0, -1, -1)
    assert cost[0].tolist() == [0.0, 2.0, 4.0]


def test_a_costly_row_is_gone_around():
    weights = grid_of(". . .".replace(" ", "9") + " .....")
    cost = wave(weights, 0, 0, -1, -1)
    cells = way_down(cost, weights, 0, 4)
    assert {tuple(cell) for cell in cells[1:-1].tolist()} <= {(1, c) for c in range(5)}


def test_what_is_walled_off_is_not_reached():
    weights = grid_of(".#.")
    cost = wave(weights, 0, 0, 0, 2)
    assert cost[0, 2] == math.inf
    assert len(way_down(cost, weights, 0, 2)) == 0


def test_the_wave_may_stop_at_the_start():
    weights = np.ones((40, 40))
    whole, part = wave(weights, 0, 0, -1, -1), wave(weights, 0, 0, 3, 4)
    assert part[3, 4] == whole[3, 4] and np.isinf(part[39, 39])


def test_a_line_over_free_cells_costs_its_length_and_a_closed_one_has_no_price():
    weights = np.ones((5, 5))
    assert line_cost(weights, np.array([0, 0]), np.array([3, 4])) == pytest.approx(5.0)
    weights[1, 2] = math.inf
    assert line_cost(weights, np.array([0, 0]), np.array([3, 4])) == math.inf


def test_corners_of_the_grid_are_cut():
    weights = np.ones((10, 10))
    cost = wave(weights, 9, 4, 0, 0)
    kept = cut_corners(way_down(cost, weights, 0, 0), weights)
    assert kept.tolist() == [[0, 0], [9, 4]]


def test_the_nearest_open_cell():
    weights = grid_of("##. ### ###")
    assert nearest_open(weights, 0, 0, 2.0) == (0, 2)
    assert nearest_open(weights, 0, 0, 1.9) == (-1, -1)
    assert nearest_open(weights, 0, 2, 0.0) == (0, 2)


grids = st.lists(st.floats(0.0, 1.0), min_size=144, max_size=144).map(
    lambda v: np.where(np.array(v) < 0.25, np.inf, 1.0 + 3.0 * np.array(v)).reshape(12, 12)
)


@FEW
@given(grids)
def test_costs_rise_by_no_more_than_a_step(weights):
    """Bellman: of no open cell is there a cheaper way over one of its neighbors."""
    weights[0, 0] = 1.0
    cost = wave(weights, 0, 0, -1, -1)
    for row, col in np.argwhere(np.isfinite(weights[:, :-1]) & np.isfinite(weights[:, 1:])):
        step = 0.5 * (weights[row, col] + weights[row, col + 1])
        if np.isfinite(cost[row, col]):
            assert abs(cost[row, col] - cost[row, col + 1]) <= step + 1e-9


@FEW
@given(grids)
def test_a_way_is_open_and_costs_what_the_wave_says(weights):
    weights[0, 0] = weights[11, 11] = 1.0
    cost = wave(weights, 11, 11, 0, 0)
    cells = way_down(cost, weights, 0, 0)
    if not len(cells):
        assert np.isinf(cost[0, 0])
        return
    assert np.isfinite(weights[tuple(cells.T)]).all()
    assert np.abs(np.diff(cells, axis=0)).max() == 1
    steps = np.hypot(*np.diff(cells, axis=0).T)
    w = weights[tuple(cells.T)]
    assert (steps * 0.5 * (w[1:] + w[:-1])).sum() == pytest.approx(cost[0, 0])


@FEW
@given(grids)
def test_there_and_back_cost_the_same(weights):
    weights[0, 0] = weights[11, 11] = 1.0
    there, back = wave(weights, 11, 11, 0, 0)[0, 0], wave(weights, 0, 0, 11, 11)[11, 11]
    assert there == pytest.approx(back)


def test_cells_nearer_than_the_robot_are_closed_and_near_ones_cost_more():
    """One obstacle, cells of 0.1 m: the robot needs 0.25 m, 0.3 m off is just open."""
    cells = np.zeros((1, 12), dtype=np.int8)
    cells[0, 0] = 100
    config = WavefrontConfig(radius_m=0.2, margin_m=0.05, near_weight=4.0, near_m=0.4)
    costs = travel_costs(OccupancyMap(cells, 0.1, SE2.identity()), config)[0]
    assert np.isinf(costs[:3]).all() and np.isfinite(costs[3:]).all()
    assert costs[3] == pytest.approx(5.0)  # 0.25 m from the edge: 1 + 4
    assert costs[5] == pytest.approx(1.0 + 4.0 * 0.25)  # 0.2 m farther: half of near_m
    assert costs[7:] == pytest.approx(np.ones(5))


def test_what_is_not_known_costs_more_or_is_closed():
    cells = np.array([[0, -1, 64, 65]], dtype=np.int8)
    grid = OccupancyMap(cells, 10.0, SE2.identity())
    costly = travel_costs(grid, WavefrontConfig(unknown_weight=3.0))[0]
    assert costly.tolist() == [1.0, 3.0, 1.0, math.inf]
    closed = travel_costs(grid, WavefrontConfig(unknown_weight=0.0))[0]
    assert closed[1] == math.inf
