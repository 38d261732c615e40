"""Section 6 by hand, and layers on other people's cells."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.map_resampling import obstacles_on
from grid_mapper.overlay import glass_layer, on_cells_of, overlay

CELL_M = 0.05
U, F, X = UNKNOWN, FREE, OCCUPIED


def grid(rows, x=0.0, y=0.0, yaw=0.0, cell=CELL_M):
    return OccupancyMap(np.array(rows, np.int8), cell, SE2(x, y, yaw))


def test_only_where_the_laser_says_free_the_sonar_decides():
    laser = grid([[U, U, U], [F, F, F], [X, X, X]])
    sonar = grid([[U, F, X], [U, F, X], [U, F, X]])
    np.testing.assert_array_equal(overlay(laser, sonar).cells, [[U, U, U], [F, F, X], [X, X, X]])
    np.testing.assert_array_equal(
        glass_layer(laser, sonar).cells, [[U, U, U], [U, U, X], [U, U, U]]
    )


def test_a_log_odds_cell_that_is_rather_free_counts_as_free():
    laser = grid([[40, 49, 50, 97]])
    sonar = grid([[X, X, X, X]])
    np.testing.assert_array_equal(overlay(laser, sonar).cells, [[X, X, 50, 97]])


def test_a_sonar_map_that_covers_another_part_is_shifted_by_whole_cells():
    laser = grid([[F, F, F, F]] * 2, x=0.10, y=-0.05)
    sonar = grid([[X, F, X]], x=0.20, y=0.0)
    np.testing.assert_array_equal(overlay(laser, sonar).cells, [[F, F, F, F], [F, F, X, F]])
    assert (on_cells_of(grid([[X]], x=50.0), laser) == U).all()


def test_without_a_sonar_the_lasers_map_stays_as_it_is():
    laser = grid([[U, F, X]])
    nothing = OccupancyMap(np.zeros((0, 0), np.int8), CELL_M, SE2.identity())
    np.testing.assert_array_equal(overlay(laser, nothing).cells, laser.cells)
    assert (glass_layer(laser, nothing).cells == U).all()


@pytest.mark.parametrize(
    "other", [grid([[X]], x=0.02), grid([[X]], yaw=0.1), grid([[X]], cell=0.1)]
)
def test_maps_of_another_lattice_are_refused(other):
    with pytest.raises(ValueError, match="lattice"):
        overlay(grid([[F]]), other)


@given(
    laser=st.lists(st.sampled_from([U, F, X]), min_size=12, max_size=12),
    sonar=st.lists(st.sampled_from([U, F, X]), min_size=12, max_size=12),
)
def test_map_and_glass_agree(laser, sonar):
    a, b = grid(np.reshape(laser, (3, 4))), grid(np.reshape(sonar, (3, 4)))
    whole, glass = overlay(a, b).cells, glass_layer(a, b).cells
    np.testing.assert_array_equal(whole == X, (a.cells == X) | (glass == X))
    np.testing.assert_array_equal(whole == U, a.cells == U)


def test_a_thin_pane_stays_whole_on_finer_and_on_coarser_cells():
    pane = grid([[U, X, U]] * 8)
    fine = grid(np.full((40, 20), U), x=-0.01, y=0.0, cell=0.02)
    on_fine = obstacles_on(pane, fine)
    centers = fine.to_points(np.argwhere(on_fine.cells == X))
    assert centers[:, 0].min() == pytest.approx(0.06) and centers[:, 0].max() < 0.10
    assert len(np.unique(np.round(centers[:, 1], 4))) == 20  # 0.40 m in rows of 0.02 m
    coarse = grid(np.full((3, 3), U), cell=0.2)
    np.testing.assert_array_equal(obstacles_on(pane, coarse).cells, [[X, U, U], [X, U, U], [U] * 3])


def test_a_turned_reference_keeps_every_obstacle_where_it_is():
    pane = grid([[U, X, U]] * 40)
    turned = grid(np.full((80, 80), U), x=1.0, y=-1.5, yaw=0.7)
    found = obstacles_on(pane, turned)
    centers = turned.to_points(np.argwhere(found.cells == X))
    assert np.abs(centers[:, 0] - 0.075).max() < 0.065  # half a cell each, and a corner
    for y in np.arange(0.1, 1.9, 0.05):
        there = turned.to_cells(np.array([[0.075, y]]))[0]
        if (there >= 0).all() and (there < 80).all():
            near = found.cells[
                max(there[0] - 1, 0) : there[0] + 2, max(there[1] - 1, 0) : there[1] + 2
            ]
            assert (near == X).any()


def test_nothing_to_show_is_all_unknown_of_the_references_size():
    like = grid(np.full((3, 7), F), x=4.0)
    result = obstacles_on(grid([[U, F]]), like)
    assert result.cells.shape == (3, 7) and (result.cells == U).all()
    assert (result.origin, result.resolution) == (like.origin, like.resolution)
