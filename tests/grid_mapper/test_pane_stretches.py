"""Glass, openings and bays along a line."""

import numpy as np
import pytest
from view_builders import drive_along, views

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.bayes_config import BayesConfig
from grid_mapper.config import LogOddsConfig
from grid_mapper.opaque_cells import OpaqueCells
from grid_mapper.pane_lines import find_lines
from grid_mapper.pane_stretches import stretches

UP = np.pi / 2.0
TOL_M = 0.15  # the spot an echo comes from, and a cell


def open_cells(*posts):
    """Return the laser's cells of a room that is free but for posts, each at its (x, y)."""
    cells = OpaqueCells(0.05)
    for k in range(8):
        at = SE2(0.2 * k, 0.0, 0.0)
        angles = [np.arctan2(y - at.y, x - at.x) for x, y in posts]
        ranges = np.full(721, np.inf)
        for (x, y), angle in zip(posts, angles, strict=True):
            index = round((angle + np.pi) / (np.pi / 360.0))
            ranges[index - 2 : index + 3] = np.hypot(x - at.x, y - at.y)
        scan = Scan(ranges, -np.pi, np.pi / 360.0, 0.05, 10.0)
        cells.add_scan(scan, at, k * 10**9, LogOddsConfig())
    return cells.cells


def found(rows, cells, config=None):
    """Return the stretches of the only line, along +x."""
    config = config or BayesConfig()
    (line,) = find_lines(views(*rows), config)
    ends = stretches(line, views(*rows), config, cells).glass
    return sorted((-b, -a) for a, b in ends.tolist())  # the line runs along -x


def test_glass_is_where_echoes_came_from():
    ((low, high),) = found(drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5), open_cells())
    assert (low, high) == (pytest.approx(0.0, abs=TOL_M), pytest.approx(0.9, abs=TOL_M))


def test_a_pane_is_carried_on_to_the_next_post():
    rows = drive_along(np.arange(0.0, 0.8, 0.1), 0.0, 1.5)
    ((_, high),) = found(rows, open_cells((1.4, 1.5)))
    assert high == pytest.approx(1.4, abs=TOL_M)


def test_a_pane_is_not_carried_on_over_an_opening():
    rows = drive_along(np.arange(0.0, 0.8, 0.1), 0.0, 1.5)
    rows += drive_along(np.arange(0.9, 1.2, 0.1), 0.0, None)
    ((_, high),) = found(rows, open_cells((1.4, 1.5)))
    assert high == pytest.approx(0.75, abs=TOL_M)


def test_a_pane_ends_in_the_open_where_nothing_was_heard_of_it():
    rows = drive_along(np.arange(0.0, 0.8, 0.1), 0.0, 1.5)
    ((_, high),) = found(rows, open_cells())
    assert high == pytest.approx(0.7, abs=TOL_M)


def test_a_slanted_miss_says_nothing():
    rows = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    slanted = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, None, UP + 0.4)
    assert found(rows + slanted, open_cells()) == found(rows, open_cells())


def test_what_newer_readings_miss_has_gone():
    rows = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    gone = drive_along(np.arange(0.0, 1.0, 0.03), -0.2, None)
    assert found(rows + gone, open_cells()) == []


def test_what_newer_readings_hear_again_is_there():
    gone = drive_along(np.arange(0.0, 1.0, 0.1), -0.2, None)
    rows = drive_along(np.arange(0.0, 1.0, 0.03), 0.0, 1.5)
    assert len(found(gone + rows, open_cells())) == 1


@pytest.mark.parametrize(("pane_views", "end"), [(6.0, 1.05), (2.0, 1.6)])
def test_only_what_misses_leave_enough_of_is_carried_on(pane_views, end):
    rows = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    gone = drive_along(np.arange(0.0, 0.4, 0.03), -0.2, None)
    config = BayesConfig(pane_views=pane_views, pane_baseline_m=0.05)
    ((low, high),) = found(rows + gone, open_cells((1.6, 1.5)), config)
    assert low > 0.5
    assert high == pytest.approx(end, abs=TOL_M)


def test_newer_misses_clear_even_what_was_heard_much_more_often():
    rows = drive_along(np.arange(0.0, 1.0, 0.01), 0.0, 1.5)
    for num, is_there in ((2, True), (4, False)):
        gone = drive_along(np.full(num, 0.5), -0.2, None)
        spans = found(rows + gone, open_cells(), BayesConfig(max_bay_m=0.2))
        assert any(low < 0.5 < high for low, high in spans) == is_there


def test_misses_older_than_enough_echoes_are_forgotten():
    gone = drive_along(np.arange(0.0, 1.0, 0.01), -0.2, None)
    rows = drive_along(np.arange(0.03, 1.0, 0.06), 0.0, 1.5)
    ((low, high),) = found(gone + rows, open_cells())
    assert (low, high) == (pytest.approx(0.0, abs=TOL_M), pytest.approx(1.0, abs=TOL_M))


def test_misses_from_afar_do_not_clear_what_was_heard_well():
    rows = drive_along(np.arange(0.0, 1.0, 0.05), 0.0, 1.5)
    afar = drive_along(np.arange(0.0, 1.0, 0.08), -0.8, None)
    ((low, high),) = found(rows + afar, open_cells())
    assert (low, high) == (pytest.approx(0.0, abs=TOL_M), pytest.approx(0.95, abs=TOL_M))
    assert found(rows + afar, open_cells(), BayesConfig(trusted_m=3.0)) == []


def test_misses_from_afar_still_keep_a_bay_open_that_nothing_was_heard_of():
    rows = drive_along(np.arange(0.0, 0.8, 0.1), 0.0, 1.5)
    rows += drive_along(np.arange(0.9, 1.2, 0.05), -0.8, None)
    ((_, high),) = found(rows, open_cells((1.4, 1.5)))
    assert high < 1.0


def test_misses_at_a_slant_count_only_within_the_critical_angle():
    rows = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    slanted = drive_along(np.arange(-1.0, 1.5, 0.03), 0.0, None, UP + 0.3)
    assert found(rows + slanted, open_cells(), BayesConfig(critical_rad=0.15)) != []
    assert found(rows + slanted, open_cells(), BayesConfig(critical_rad=0.4)) == []


def test_a_way_beside_a_pane_is_none_through_it():
    rows = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    beside = drive_along(np.arange(0.0, 1.0, 0.05), 1.4, 0.1)
    ahead = drive_along(np.arange(0.0, 1.0, 0.05), 1.4, None, 0.0)
    ((low, high),) = found(rows + beside + ahead, open_cells())
    assert (low, high) == (pytest.approx(0.0, abs=TOL_M), pytest.approx(0.95, abs=TOL_M))


def test_where_the_robot_went_there_is_no_glass():
    rows = drive_along(np.arange(0.0, 0.6, 0.1), 0.0, 1.5)
    rows += drive_along(np.arange(1.0, 1.6, 0.1), 0.0, 1.5)
    through = [(0.8, float(y), UP, 3.0) for y in np.arange(1.4, 1.65, 0.05)]
    spans = found(rows, open_cells())
    assert any(low < 0.8 < high for low, high in spans)
    spans = found(rows + through, open_cells())
    assert not any(low < 0.8 < high for low, high in spans)
