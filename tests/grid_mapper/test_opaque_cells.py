"""Log-odds and hits of what the laser crosses."""

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import LogOddsConfig
from grid_mapper.opaque_cells import OpaqueCells, at

S = 10**9


def beam(r):
    return Scan(np.array([r]), 0.0, 0.01, 0.05, 10.0)


def fed(ranges, step_s=1.0):
    cells = OpaqueCells(0.05)
    for k, r in enumerate(ranges):
        cells.add_scan(beam(r), SE2(0.025, 0.025, 0.0), round(k * step_s * S), LogOddsConfig())
    return cells


def test_a_wall_is_opaque():
    log_odds, hits = at(fed([1.0] * 4).cells, 1.025, 0.025)
    assert log_odds > 0.0
    assert hits == 4


def test_what_is_crossed_more_often_than_hit_is_not_opaque_but_was_hit():
    log_odds, hits = at(fed([1.0, 3.0, 3.0, 3.0, 3.0]).cells, 1.025, 0.025)
    assert log_odds < 0.0
    assert hits == 1


def test_a_robot_that_stands_still_counts_by_time_and_not_by_scans():
    slow, fast = fed([1.0] * 3, 1.0), fed([1.0] * 201, 0.01)  # 2 s both
    assert at(fast.cells, 1.025, 0.025)[1] <= 2 * at(slow.cells, 1.025, 0.025)[1]


def test_nothing_is_known_of_what_no_beam_reached():
    assert at(fed([1.0]).cells, 40.0, -7.0) == (0.0, 0)


def test_the_dense_array_begins_at_its_origin():
    values, origin = fed([1.0] * 4).dense()
    col, row = np.floor(((1.025 - origin.x) / 0.05, (0.025 - origin.y) / 0.05)).astype(int)
    assert values[row, col] == values.max() > 0.0
