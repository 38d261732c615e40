"""Map files: read back equal, whole or not at all, and as map_server means them."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper import map_files
from grid_mapper.map_files import load_map, save_map

TRINARY = st.sampled_from([-1, 0, 100])
ANY = st.integers(-1, 100)
SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, max_side=9)


def a_map() -> OccupancyMap:
    cells = np.array([[0, 100, -1], [-1, 0, 0]], np.int8)
    return OccupancyMap(cells, 0.05, SE2(-1.5, 2.25, 0.3))


@pytest.mark.parametrize(("mode", "values"), [("trinary", TRINARY), ("scale", ANY), ("raw", ANY)])
def test_what_was_saved_is_read_back(tmp_path, mode, values):
    @settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(hnp.arrays(np.int8, SHAPES, elements=values), st.floats(-9, 9), st.floats(-3, 3))
    def check(cells, x, yaw):
        grid = OccupancyMap(cells, 0.05, SE2(x, -2.0, yaw))
        back = load_map(save_map(tmp_path / "m", grid, mode, overwrite=True))
        assert (back.cells == cells).all()
        assert back.resolution == 0.05
        assert back.origin == grid.origin

    check()


def test_the_file_is_what_map_server_expects(tmp_path):
    header = yaml.safe_load(save_map(tmp_path / "m", a_map()).read_text())
    assert header["image"] == "m.pgm" and header["mode"] == "trinary" and header["negate"] == 0
    assert header["origin"] == pytest.approx([-1.5, 2.25, 0.3])
    image = cv2.imread(str(tmp_path / "m.pgm"), cv2.IMREAD_UNCHANGED)
    assert image.tolist() == [[205, 254, 254], [254, 0, 205]]


def test_unknown_stays_unknown_for_readers_with_either_free_threshold(tmp_path):
    header = yaml.safe_load(save_map(tmp_path / "m", a_map()).read_text())
    assert header["free_thresh"] <= (255 - 205) / 255


@pytest.mark.parametrize("negate", [0, 1])
def test_other_peoples_maps_are_read(tmp_path, negate):
    image = np.array([[0, 255, 128]], np.uint8)
    cv2.imwrite(str(tmp_path / "x.png"), 255 - image if negate else image)
    text = f"image: x.png\nresolution: 0.03\norigin: [1, 2, 0]\nnegate: {negate}\n"
    (tmp_path / "x.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    assert load_map(tmp_path / "x.yaml").cells.tolist() == [[100, 0, -1]]


def test_nothing_is_overwritten_unless_asked(tmp_path):
    save_map(tmp_path / "m", a_map())
    with pytest.raises(FileExistsError, match="another name"):
        save_map(tmp_path / "m", a_map())


def test_a_failed_write_leaves_nothing_behind(tmp_path, monkeypatch):
    def full_disk(_fd):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(map_files.os, "fsync", full_disk)
    with pytest.raises(OSError, match="No space"):
        save_map(tmp_path / "m", a_map())
    assert list(tmp_path.iterdir()) == []


def test_an_image_whose_header_cannot_be_moved_into_place_is_taken_away(tmp_path, monkeypatch):
    move = Path.replace

    def refuse_yaml(self, target):
        if Path(target).suffix == ".yaml":
            raise PermissionError(13, "Permission denied")
        return move(self, target)

    monkeypatch.setattr(Path, "replace", refuse_yaml)
    with pytest.raises(PermissionError):
        save_map(tmp_path / "m", a_map())
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "m.pgm").write_bytes(b"older")
    with pytest.raises(PermissionError):
        save_map(tmp_path / "m", a_map(), overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["m.pgm"]


@pytest.mark.parametrize(
    ("text", "message"),
    [("- 1\n", "not a map file"), ("image: x.pgm\n", "lacks resolution, origin"),
     ("image: none.pgm\nresolution: 1\norigin: [0, 0, 0]\n", "is not there")],
)  # fmt: skip
def test_a_broken_map_file_is_refused_with_the_reason(tmp_path, text, message):
    (tmp_path / "m.yaml").write_text(text)
    with pytest.raises((ValueError, FileNotFoundError), match=message):
        load_map(tmp_path / "m.yaml")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [("resolution", ".nan", "resolution must be a number, got nan"),
     ("resolution", "fine", "resolution must be a number, got 'fine'"),
     ("origin", "[0.0]", "origin must be 3 numbers"),
     ("origin", "[.inf, 0, 0]", "origin must be 3 numbers"),
     ("origin", "3", "origin must be 3 numbers, got 3"),
     ("free_thresh", ".nan", "free_thresh must be a number")],
)  # fmt: skip
def test_a_key_that_is_no_number_is_refused_by_its_name(tmp_path, key, value, message):
    path = save_map(tmp_path / "m", a_map())
    kept = [line for line in path.read_text().splitlines() if not line.startswith(f"{key}:")]
    path.write_text("\n".join([*kept, f"{key}: {value}"]))
    with pytest.raises(ValueError, match=message):
        load_map(path)


def test_bad_arguments_are_named(tmp_path):
    with pytest.raises(ValueError, match="mode"):
        save_map(tmp_path / "m", a_map(), mode="grey")
    with pytest.raises(ValueError, match="no cells"):
        save_map(tmp_path / "m", OccupancyMap(np.zeros((0, 0), np.int8), 0.05, SE2.identity()))
    assert math.isclose(load_map(save_map(tmp_path / "m", a_map())).resolution, 0.05)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    grid = OccupancyMap(np.zeros((2, 2), np.int8), 0.05, SE2.identity())
    with pytest.raises(FileNotFoundError, match="no folder .*/nowhere"):
        save_map(tmp_path / "nowhere" / "floor", grid)
