import numpy as np
import pytest

from floornav_common.grid import OCCUPIED, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.map_files import save_map
from grid_mapper.start_map import load_start_map


@pytest.fixture
def folder(tmp_path):
    """What map_bag leaves: a map of one obstacle, and something else beside it."""
    cells = np.zeros((4, 4), np.int8)
    cells[1, 2] = OCCUPIED
    save_map(tmp_path / "map", OccupancyMap(cells, 0.05, SE2.identity()))
    (tmp_path / "README.md").write_text("# Map: `of` a floor\n\nkey: [value\n")
    return tmp_path


def test_the_file_of_a_map_is_read(folder):
    assert load_start_map(folder / "map.yaml").occupancy.cells[1, 2] == OCCUPIED


@pytest.mark.parametrize(
    ("given", "message"),
    [("", "is a folder: give the map in it, .*/map.yaml$"),
     ("map.pgm", "is an image: give the map's file, .*/map.yaml$"),
     ("README.md", r"README.md is not a map file, which is the \.yaml that map_bag")],
)  # fmt: skip
def test_what_is_no_map_is_refused_in_one_line_that_says_what_to_give(folder, given, message):
    with pytest.raises(ValueError, match=message) as found:
        load_start_map(folder / given)
    assert "\n" not in str(found.value)


def test_a_file_of_bytes_is_no_map(tmp_path):
    (tmp_path / "map.yaml").write_bytes(b"\xcd\xff\x00")
    with pytest.raises(ValueError, match="is not a map file"):
        load_start_map(tmp_path / "map.yaml")


def test_a_folder_without_a_map_names_no_file_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match=r"is a folder: give the map in it, a \.yaml file of"):
        load_start_map(tmp_path)
