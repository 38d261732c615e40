"""The log-odds grid: by hand, and what repeated rays do."""

import math

import numpy as np
import pytest

from floornav_common.grid import UNKNOWN
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import LogOddsConfig
from grid_mapper.log_odds import LogOddsGrid, log_odds, trace_rays

RESOLUTION = 0.1
CONFIG = LogOddsConfig(p_hit=0.7, p_miss=0.4, p_max=0.97)


def row_of(grid: LogOddsGrid) -> np.ndarray:
    """Return the percents of the cells of row 0 from column 0 on."""
    m = grid.occupancy()
    row, col = m.to_cells(np.array([[0.05, 0.05]]))[0]
    return m.cells[row, col:]


def one_beam(value: float) -> Scan:
    return Scan(np.array([value]), 0.0, 0.01, 0.05, 5.0)


def test_one_beam_by_hand():
    grid = LogOddsGrid(CONFIG, RESOLUTION)
    grid.add_scan(one_beam(0.55), SE2(0.05, 0.05, 0.0))
    assert row_of(grid)[:8].tolist() == [40] * 6 + [70, UNKNOWN]


def test_a_second_look_adds_log_odds():
    grid = LogOddsGrid(CONFIG, RESOLUTION)
    for _ in range(2):
        grid.add_scan(one_beam(0.55), SE2(0.05, 0.05, 0.0))
    hit = 1.0 / (1.0 + math.exp(-2.0 * log_odds(0.7)))
    assert row_of(grid)[6] == round(100 * hit)


def test_belief_is_bounded_so_that_a_moved_thing_can_be_cleared():
    grid = LogOddsGrid(CONFIG, RESOLUTION)
    for _ in range(100):
        grid.add_scan(one_beam(0.55), SE2(0.05, 0.05, 0.0))
    assert row_of(grid)[6] == 97
    for _ in range(20):
        grid.add_scan(one_beam(2.05), SE2(0.05, 0.05, 0.0))
    assert row_of(grid)[6] < 10


@pytest.mark.parametrize("yaw", np.linspace(-3.1, 3.1, 9))
def test_a_ray_is_a_line_without_gaps_that_ends_where_it_should(yaw):
    grid = LogOddsGrid(CONFIG, RESOLUTION)
    pose = SE2(0.03, 0.04, yaw)
    grid.add_scan(one_beam(3.0), pose)
    m = grid.occupancy()
    cells = np.argwhere(m.cells != UNKNOWN)
    end = pose @ np.array([[3.0, 0.0]])
    assert m.cells[tuple(m.to_cells(end)[0])] == 70
    start = m.to_cells(np.array([[0.03, 0.04]]))[0]
    steps = np.abs(m.to_cells(end)[0] - start)
    assert len(cells) == steps.max() + 1
    distance = np.abs((m.to_points(cells) - [0.03, 0.04]) @ [-math.sin(yaw), math.cos(yaw)])
    assert distance.max() < RESOLUTION


def test_a_beam_without_return_marks_nothing_occupied():
    grid = LogOddsGrid(CONFIG, RESOLUTION)
    grid.add_scan(one_beam(math.inf), SE2(0.05, 0.05, 0.0))
    assert (grid.occupancy().cells <= 40).all()


def test_a_cell_whose_hits_and_misses_cancel_stays_seen():
    grid = LogOddsGrid(LogOddsConfig(p_hit=0.6, p_miss=0.4), RESOLUTION)
    for value in (0.55, 2.05):
        grid.add_scan(one_beam(value), SE2(0.05, 0.05, 0.0))
    assert row_of(grid)[6] == 50


def test_cells_without_a_tile_are_skipped():
    values = np.zeros((2, 64, 64), np.float32)
    table, corner = np.array([[0]], np.int32), np.zeros(2, np.int64)
    steps = np.float32(-0.4), np.float32(0.8), np.float32(3.0)
    end, hit = np.array([100.0]), np.array([True])
    trace_rays(np.array([[0.5, 0.5]]), np.zeros(1), end, hit, *steps, values, table, corner)
    assert np.count_nonzero(values[0]) == 64
    assert not values[1].any()
