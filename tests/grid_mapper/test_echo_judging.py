"""What an echo says of glass."""

import numpy as np
import pytest
from view_builders import ALL_OPEN, HALF, views

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import LogOddsConfig
from grid_mapper.echo_judging import NUM_RAYS, best_normal, judge, opaque_at, open_rays
from grid_mapper.opaque_cells import OpaqueCells
from grid_mapper.sonar_views import END

EXPLAINED_M = 0.06


def wall_at(x, low=-10.0, high=10.0):
    """Return the laser's cells of a wall across +x, from `low` to `high` along y."""
    cells = OpaqueCells(0.05)
    angles = np.deg2rad(0.25) * np.arange(-240, 241)
    y = x * np.tan(angles)
    ranges = np.where((y >= low) & (y <= high), x / np.cos(angles), np.inf)
    scan = Scan(ranges, float(angles[0]), np.deg2rad(0.25), 0.05, 10.0)
    for k in range(3):
        cells.add_scan(scan, SE2(0.0, 0.0, 0.0), k * 10**9, LogOddsConfig())
    return cells.cells


def ahead(r):
    (view,) = views((0.0, 0.0, 0.0, r))
    return view


def test_a_ray_ends_at_the_first_opaque_cell():
    assert opaque_at(wall_at(2.01), 0.0, 0.0, 0.0, 5.0) == pytest.approx(2.0, abs=0.026)
    assert opaque_at(wall_at(2.01), 0.0, 0.0, np.pi, 5.0) == np.inf


def test_an_echo_at_the_range_of_a_wall_is_explained():
    assert open_rays(ahead(2.0), EXPLAINED_M, wall_at(2.0)) == 0


def test_an_echo_before_the_wall_may_be_glass_in_the_whole_cone():
    assert open_rays(ahead(1.5), EXPLAINED_M, wall_at(2.0)) == ALL_OPEN


def test_an_echo_from_behind_a_wall_came_by_mirrors():
    assert open_rays(ahead(3.0), EXPLAINED_M, wall_at(2.0)) == 0


def test_only_the_part_of_the_arc_beside_a_wall_is_open():
    rays = open_rays(ahead(3.0), EXPLAINED_M, wall_at(2.0, low=0.05))  # covers the cone's left
    is_open = [(int(rays) >> k) & 1 for k in range(NUM_RAYS)]
    assert is_open[0] == 1
    assert is_open[-1] == 0
    assert is_open == sorted(is_open, reverse=True)


def test_the_best_normal_is_the_one_that_echoes_near_by_share():
    yaw = 0.1  # the pane is across x, the sonar looks past its normal
    rows = views(*[(0.0, 0.1 * k, yaw, 1.5) for k in range(6)])
    normal, score = best_normal(rows, 2, np.array([5]), 0.02, 0.01)
    assert normal == pytest.approx(0.0, abs=2.0 * HALF / (NUM_RAYS - 1))
    assert score > 4.0


def test_echoes_of_unlike_ranges_share_no_normal():
    rows = views((0.0, 0.0, 0.0, 1.5), (0.0, 0.1, 0.0, 2.5), (0.0, 0.2, 0.0, 0.7))
    assert best_normal(rows, 0, np.array([2]), 0.02, 0.01)[1] == 0.0


def test_judging_leaves_free_readings_alone_and_explains_echoes():
    rows = views((0.0, 0.0, 0.0, None), (0.0, 0.0, 0.0, 2.0))
    rows["next"] = END
    before = rows[0].copy()
    firsts = np.full((2, 9), END)
    judge(rows, np.array([0, 1]), firsts, EXPLAINED_M, 0.02, 0.01, wall_at(2.0))
    assert rows[0] == before
    assert (rows[1]["open"], rows[1]["score"]) == (0, 0.0)
