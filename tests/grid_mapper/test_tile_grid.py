"""The tiled plane: it grows where asked, keeps what it held, and costs only what is touched."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grid_mapper.tile_grid import TILE_CELLS, TileGrid, find_slot, missing_on_rays

tiles = st.lists(
    st.tuples(st.integers(-6, 6), st.integers(-6, 6)), min_size=1, max_size=8
)  # fmt: skip


@given(st.lists(tiles, min_size=1, max_size=5))
def test_values_stay_where_they_were_while_the_plane_grows(steps):
    grid = TileGrid(0.1, value=(np.int32, ()))
    expected: dict = {}
    for number, step in enumerate(steps, start=1):
        grid.ensure_tiles(np.array(step, np.int64))
        row, col = np.array(step[0]) * TILE_CELLS + [number, 2 * number]
        slot = find_slot(grid.table, grid.corner, row, col)
        grid.fields["value"][slot, row % TILE_CELLS, col % TILE_CELLS] = number
        expected[int(row), int(col)] = number
    dense, corner = grid.dense("value")
    found = {
        (int(r + corner[0]), int(c + corner[1])): int(dense[r, c]) for r, c in np.argwhere(dense)
    }
    assert found == expected


def test_a_frozen_plane_reaches_as_far_as_it_did():
    grid = TileGrid(0.1, value=(np.int32, ()))
    grid.ensure_tiles(np.array([[0, 0], [1, 1]]))
    grid.fields["value"][0, 3, 4] = 7
    frozen = grid.frozen()
    grid.ensure_tiles(np.array([[0, 1], [-9, 9]]))  # within its table, and beyond
    dense, corner = frozen.dense("value")
    assert dense.shape == (2 * TILE_CELLS, 2 * TILE_CELLS) and corner.tolist() == [0, 0]
    assert dense[3, 4] == 7 and frozen.num_tiles == 2
    assert find_slot(frozen.table, frozen.corner, 0, TILE_CELLS) == -1


def test_memory_grows_with_the_area_touched_not_with_the_distance():
    grid = TileGrid(0.05, value=(np.int8, ()))
    grid.ensure_tiles(np.array([[0, 0], [300, 300]]))
    assert grid.num_tiles == 2
    assert grid.num_bytes < 1_000_000


def test_an_empty_plane_is_an_empty_array():
    dense, _ = TileGrid(0.05, value=(np.int8, ())).dense("value")
    assert dense.shape == (0, 0)


@given(st.floats(-400, 400), st.floats(-400, 400), st.integers(0, 10_000))
def test_every_point_of_every_ray_has_its_tile(x, y, seed):
    rng = np.random.default_rng(seed)
    origin = np.array([x, y])
    angles = np.sort(rng.uniform(-np.pi, np.pi, 40))
    lengths = rng.uniform(0.0, 600.0, 40)
    grid = TileGrid(0.05, value=(np.int8, ()))
    origins = np.tile(origin, (len(angles), 1))
    grid.ensure_rays(origins, angles, lengths)
    ends = lengths[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    points = (origin + np.linspace(0.0, 1.0, 200)[:, None, None] * ends).reshape(-1, 2)
    cells = np.floor(points[:, ::-1]).astype(np.int64)
    assert all(find_slot(grid.table, grid.corner, r, c) >= 0 for r, c in cells)
    assert len(missing_on_rays(origins, angles, lengths, grid.table, grid.corner)) == 0
