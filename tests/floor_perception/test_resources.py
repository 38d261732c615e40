"""Files that parameters name."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from floor_perception.resources import find_file, load_camera_model, load_hidden_mask
from floornav_common.camera_files import load_floor_camera


@pytest.mark.parametrize("name", ["soccer_small_size", "soccer_middle_size"])
def test_the_simulated_robots_cameras_are_the_simulators(name: str) -> None:
    folder = resources.files("sim_bridge") / "camera_models"
    assert load_camera_model(name) == load_floor_camera(Path(str(folder / f"{name}.yaml")))


def test_a_path_is_taken_as_it_is_and_a_name_must_be_known() -> None:
    assert find_file("a/b.yaml", "camera_models") == Path("a/b.yaml")
    with pytest.raises(ValueError, match="soccer_small_size"):
        find_file("nobody", "camera_models")


def test_a_hidden_mask_must_be_a_picture(tmp_path: Path) -> None:
    assert load_hidden_mask("") is None
    with pytest.raises(ValueError, match="not a picture"):
        load_hidden_mask(str(tmp_path / "none.png"))
