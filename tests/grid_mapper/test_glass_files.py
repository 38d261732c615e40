"""What is saved beside a map of a robot with sonars."""

import numpy as np
import pytest

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.glass_files import SUFFIXES, keepout_mask, save_layers
from grid_mapper.layers_moment import Layers
from grid_mapper.map_files import free_prefix, load_map

CELL_M = 0.05


def grid(value, marked=None):
    cells = np.full((21, 21), value, np.int8)
    if marked is not None:
        cells[marked] = OCCUPIED
    return OccupancyMap(cells, CELL_M, SE2(1.0, 2.0, 0.0))


NOTHING = OccupancyMap(np.zeros((0, 0), np.int8), CELL_M, SE2.identity())
LAYERS = Layers(grid(FREE, (10, 10)), grid(FREE), grid(FREE, (10, 10)), grid(UNKNOWN, (10, 10)))


def test_map_glass_and_keepout_are_saved_and_read_back(tmp_path):
    paths = save_layers(tmp_path / "m", LAYERS, keepout_margin=0.1)
    assert [p.name for p in paths] == ["m.yaml", "m_glass.yaml", "m_keepout.yaml"]
    np.testing.assert_array_equal(load_map(paths[0]).cells, LAYERS.occupancy.cells)
    np.testing.assert_array_equal(load_map(paths[1]).cells, LAYERS.glass.cells)
    mask = load_map(paths[2])
    assert (mask.cells == OCCUPIED).sum() == 13 and (mask.cells == FREE).sum() == 21 * 21 - 13
    assert (mask.origin, mask.resolution) == (LAYERS.occupancy.origin, CELL_M)


def test_the_mask_reaches_as_far_as_asked_and_is_never_unknown():
    for margin, expected in ((0.0, 1), (0.05, 5), (0.08, 9)):
        mask = keepout_mask(LAYERS.glass, margin)
        assert (mask.cells == OCCUPIED).sum() == expected and not (mask.cells == UNKNOWN).any()


def test_a_robot_without_sonars_saves_its_map_alone(tmp_path):
    layers = Layers(grid(FREE), grid(FREE), NOTHING, grid(UNKNOWN))
    assert [p.name for p in save_layers(tmp_path / "m", layers, keepout_margin=0.1)] == ["m.yaml"]


def test_without_a_margin_there_is_no_mask(tmp_path):
    save_layers(tmp_path / "m", LAYERS)
    assert not (tmp_path / "m_keepout.yaml").exists()


def test_no_file_is_written_over_and_then_none_at_all(tmp_path):
    (tmp_path / "m_keepout.pgm").touch()
    with pytest.raises(FileExistsError, match="another name"):
        save_layers(tmp_path / "m", LAYERS, keepout_margin=0.1)
    assert [p.name for p in tmp_path.iterdir()] == ["m_keepout.pgm"]
    assert free_prefix(tmp_path / "m", SUFFIXES) == str(tmp_path / "m-2")
    assert free_prefix(tmp_path / "m") == str(tmp_path / "m")
