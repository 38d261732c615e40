"""The map of ultrasonic points against the definition of its arcs, cell by cell (section 5)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper.sonar_config import SonarConfig
from grid_mapper.sonar_grid import SonarGrid, points_of, sector_box

CELL_M = 0.05
FOV = math.radians(20.0)
HERE = SE2(0.0, 0.0, 0.0)


def echo(r, fov=FOV, high=6.0):
    return RangeReading(r, fov, 0.1, high)


def points_by_cell(grid):
    values, corner = grid.points()
    rows, cols = np.nonzero(values)
    first = (round(corner.y / CELL_M), round(corner.x / CELL_M))
    return {
        (int(r) + first[0], int(c) + first[1]): float(values[r, c])
        for r, c in zip(rows, cols, strict=True)
    }


def by_definition(r, pose, fov, tolerance=0.05):
    """Return the cells whose center lies in the arc of Fig. 2, one cell at a time."""
    cells = set()
    reach = math.ceil((r + tolerance) / CELL_M) + 1
    row0, col0 = math.floor(pose.y / CELL_M), math.floor(pose.x / CELL_M)
    for row in range(row0 - reach, row0 + reach + 1):
        for col in range(col0 - reach, col0 + reach + 1):
            dx, dy = (col + 0.5) * CELL_M - pose.x, (row + 0.5) * CELL_M - pose.y
            off = abs(math.remainder(math.atan2(dy, dx) - pose.yaw, 2.0 * math.pi))
            if abs(math.hypot(dx, dy) - r) <= tolerance and off <= fov / 2.0:
                cells.add((row, col))
    return cells


def state_at(grid, x, y):
    occupancy = grid.occupancy()
    row, col = occupancy.to_cells(np.array([[x, y]]))[0]
    return occupancy.cells[row, col]


def test_the_point_of_a_cell_is_one_over_r_squared_and_the_papers_threshold_is_4_5_in_si():
    assert points_of(2.0) == 0.25
    assert SonarConfig().min_points == pytest.approx(0.0000045 * 1000.0**2)


def test_points_of_exactly_the_threshold_make_an_obstacle():
    r = 2.0  # 0.25 points an echo: exact in binary, 18 of them are 4.5
    for num, is_obstacle in ((17, False), (18, True)):
        grid = SonarGrid(SonarConfig(min_points=4.5), CELL_M)
        for _ in range(num):
            grid.add_range(echo(r), HERE)
        assert max(points_by_cell(grid).values()) == num * 0.25
        assert (state_at(grid, r, 0.025) == OCCUPIED) == is_obstacle


def test_one_echo_alone_makes_an_obstacle_only_nearer_than_0_471_m():
    for r, expected in ((0.46, OCCUPIED), (0.48, UNKNOWN)):
        grid = SonarGrid(SonarConfig(), CELL_M)
        grid.add_range(echo(r), HERE)
        assert state_at(grid, r, 0.01) == expected, r


def test_five_echoes_at_one_meter_are_an_obstacle_and_four_are_not():
    grid = SonarGrid(SonarConfig(), CELL_M)
    for number in range(1, 6):
        grid.add_range(echo(1.0), HERE)
        assert state_at(grid, 1.01, 0.01) == (OCCUPIED if number == 5 else UNKNOWN)


@given(
    r=st.floats(0.15, 3.0), yaw=st.floats(-3.1, 3.1), fov=st.floats(0.05, 3.1),
    x=st.floats(-7.0, 7.0), y=st.floats(-7.0, 7.0),
)  # fmt: skip
@settings(max_examples=60)
def test_the_arc_holds_the_cells_that_the_definition_holds(r, yaw, fov, x, y):
    grid = SonarGrid(SonarConfig(), CELL_M)
    pose = SE2(x, y, yaw)
    assert grid.add_range(echo(r, fov), pose)
    found = points_by_cell(grid)
    # a center within rounding of an edge may fall on either side
    surely = by_definition(r, pose, fov - 1e-6, 0.05 - 1e-6)
    perhaps = by_definition(r, pose, fov + 1e-6, 0.05 + 1e-6)
    assert surely <= set(found) <= perhaps
    assert set(found.values()) <= {float(np.float32(1.0 / r**2))}


def test_what_lies_before_an_echo_is_swept_and_what_lies_behind_is_not():
    grid = SonarGrid(SonarConfig(), CELL_M)
    for _ in range(20):
        grid.add_range(echo(2.0), HERE)
    assert state_at(grid, 1.0, 0.0) == FREE
    assert state_at(grid, 2.0, 0.0) == OCCUPIED
    assert state_at(grid, 2.2, 0.0) == UNKNOWN
    assert state_at(grid, 1.0, 0.4) == UNKNOWN  # beside the cone


def test_no_echo_says_nothing_unless_a_length_is_set_free():
    silent = echo(math.inf)
    grid = SonarGrid(SonarConfig(), CELL_M)
    assert not grid.add_range(silent, HERE)
    assert grid.occupancy().cells.size == 0
    grid = SonarGrid(SonarConfig(no_echo_free_m=1.5), CELL_M)
    assert grid.add_range(silent, HERE)
    assert state_at(grid, 1.4, 0.0) == FREE and state_at(grid, 1.6, 0.0) == UNKNOWN
    assert not points_by_cell(grid)


def test_a_sweep_takes_no_obstacle_away():
    grid = SonarGrid(SonarConfig(no_echo_free_m=5.0), CELL_M)
    for _ in range(10):
        grid.add_range(echo(1.0), HERE)
    for _ in range(100):
        grid.add_range(echo(math.inf), HERE)
    assert state_at(grid, 1.0, 0.0) == OCCUPIED


def test_what_says_nothing_changes_nothing():
    grid = SonarGrid(SonarConfig(no_echo_free_m=5.0), CELL_M)
    for value in (math.nan, -math.inf, 0.0, 0.05, 6.5):
        assert not grid.add_range(echo(value), HERE)
    assert grid.num_bytes == SonarGrid(SonarConfig(), CELL_M).num_bytes


@given(turns=st.integers(0, 3), cols=st.integers(-300, 300), rows=st.integers(-300, 300))
@settings(max_examples=20)
def test_world_and_sonar_moved_together_by_whole_cells_change_nothing(turns, cols, rows):
    pose = SE2(0.013, 0.021, 0.3)
    one, other = SonarGrid(SonarConfig(), CELL_M), SonarGrid(SonarConfig(), CELL_M)
    one.add_range(echo(1.237), pose)
    move = SE2(cols * CELL_M, rows * CELL_M, turns * math.pi / 2.0)
    other.add_range(echo(1.237), move @ pose)
    centers = np.array([[(c + 0.5) * CELL_M, (r + 0.5) * CELL_M] for r, c in points_by_cell(one)])
    moved = {tuple(np.floor(p[::-1] / CELL_M).astype(int)) for p in move @ centers}
    assert moved == set(points_by_cell(other))


@given(yaw=st.floats(-3.2, 3.2), half=st.floats(0.01, 1.57), far=st.floats(0.0, 80.0))
@settings(max_examples=50)
def test_the_box_holds_every_point_of_the_sector(yaw, half, far):
    origin = np.array([3.3, -7.8])
    row0, col0, row1, col1 = sector_box(origin, yaw, half, far)
    angles = yaw + np.linspace(-half, half, 50)
    for r in (0.0, 0.5 * far, far):
        x, y = origin[0] + r * np.cos(angles), origin[1] + r * np.sin(angles)
        assert (x >= col0 - 1e-9).all() and (x <= col1 + 1 + 1e-9).all()
        assert (y >= row0 - 1e-9).all() and (y <= row1 + 1 + 1e-9).all()
