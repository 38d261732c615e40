"""Rows of evenly spaced posts among what the laser sees."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.post_rows import post_rows

RESOLUTION = 0.05
ORIGIN = SE2(-1.0, -2.0, 0.0)


def rows_of(*posts, size=1, wall=None):
    """Return the rows found among posts at (x, y), `size` cells wide."""
    cells = np.full((120, 160), -2.0, np.float32)
    for x, y in posts:
        row, col = int((y - ORIGIN.y) / RESOLUTION), int((x - ORIGIN.x) / RESOLUTION)
        cells[row : row + size, col : col + size] = 2.0
    if wall is not None:
        cells[wall, 5:155] = 2.0
    return post_rows(cells, ORIGIN, RESOLUTION, 1.6)


def test_three_posts_evenly_spaced_are_one_row():
    (row,) = rows_of((0.01, 1.01), (1.01, 1.01), (2.01, 1.01), size=2)
    ends = np.array([row.low, row.high])
    way = np.array([-np.sin(row.theta), np.cos(row.theta)])
    foot = row.rho * np.array([np.cos(row.theta), np.sin(row.theta)])
    points = foot + ends[:, None] * way
    np.testing.assert_allclose(points[:, 1], 1.05, atol=0.03)
    np.testing.assert_allclose(sorted(points[:, 0]), [-0.075, 2.175], atol=0.03)
    assert not len(row.echoes)


def test_a_slanted_row_is_one_too_and_longer_ones_are_found_whole():
    (row,) = rows_of(*[(0.8 * k, 0.6 * k) for k in range(5)])
    assert row.high - row.low == pytest.approx(4.25, abs=0.06)


@pytest.mark.parametrize(
    "posts",
    [
        [(0.0, 1.0), (1.0, 1.0)],  # two are no row
        [(0.0, 1.0), (1.0, 1.0), (2.3, 1.0)],  # uneven
        [(0.0, 1.0), (1.0, 1.0), (2.0, 1.3)],  # not in line
        [(0.0, 1.0), (0.3, 1.0), (0.6, 1.0)],  # too near for a bay: legs of a table
        [(0.0, 1.0), (1.8, 1.0), (3.6, 1.0)],  # farther than a bay is long
        [],
    ],
)
def test_other_posts_are_no_row(posts):
    assert rows_of(*posts) == []


def test_walls_and_thick_columns_are_no_posts():
    assert rows_of((0.0, 1.0), (1.0, 1.0), (2.0, 1.0), size=6) == []
    assert rows_of(wall=60) == []


def test_nothing_seen_has_no_rows():
    assert post_rows(np.zeros((0, 0), np.float32), ORIGIN, RESOLUTION, 1.6) == []
