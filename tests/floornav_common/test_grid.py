"""Occupancy maps: cells and points belong together, also where the map is turned."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2


def grid(origin: SE2) -> OccupancyMap:
    return OccupancyMap(np.zeros((20, 30), np.int8), 0.1, origin)


def test_cell_zero_is_at_the_origin_corner():
    m = grid(SE2(1.0, 2.0, 0.0))
    assert m.to_points(np.array([[0, 0], [1, 3]])) == pytest.approx(
        np.array([[1.05, 2.05], [1.35, 2.15]])
    )
    assert m.to_cells(np.array([[1.05, 2.05]])).tolist() == [[0, 0]]


def test_a_turned_map_turns_its_cells():
    m = grid(SE2(0.0, 0.0, math.pi / 2.0))
    assert m.to_points(np.array([[0, 9]])) == pytest.approx(np.array([[-0.05, 0.95]]))


@given(st.integers(-50, 50), st.integers(-50, 50), st.floats(-9, 9), st.floats(-9, 9),
       st.floats(-3, 3))  # fmt: skip
def test_cells_survive_the_round_trip(row, col, x, y, yaw):
    m = grid(SE2(x, y, yaw))
    cells = np.array([[row, col]])
    assert (m.to_cells(m.to_points(cells)) == cells).all()


def test_cells_of_another_type_are_refused():
    with pytest.raises(ValueError, match="int8"):
        OccupancyMap(np.zeros((2, 2)), 0.1, SE2.identity())
