"""Files that parameters name."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from floor_perception.config import CameraNodeConfig, FloorDetectorConfig, FloorNodeConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.resources import find_file, load_camera_model, load_hidden_mask
from floornav_common.camera_files import load_floor_camera
from floornav_common.config_files import load_config

PARAMETERS = Path(__file__).parents[2] / "ros_ws/src/floor_perception/parameters"


def test_the_parameters_of_a_middle_size_robot_fit_its_camera() -> None:
    """No key is unknown, and the camera sees all of the template."""
    path = PARAMETERS / "middle_size.yaml"
    node = load_config(path, CameraNodeConfig, others=[FloorDetectorConfig, FloorNodeConfig])
    config = load_config(path, FloorDetectorConfig, others=[CameraNodeConfig, FloorNodeConfig])
    detector = FloorDetector(load_camera_model(node.camera_model), config)
    assert (detector.template.edges[0], detector.template.edges[-1]) == (0.6, 4.0)


@pytest.mark.parametrize("name", ["soccer_small_size", "soccer_middle_size"])
def test_the_simulated_robots_cameras_are_the_simulators(name: str) -> None:
    folder = resources.files("sim_bridge") / "camera_models"
    assert load_camera_model(name) == load_floor_camera(Path(str(folder / f"{name}.yaml")))


def test_a_path_is_taken_as_it_is_and_a_name_must_be_known() -> None:
    assert find_file("a/b.yaml", "colors") == Path("a/b.yaml")
    with pytest.raises(ValueError, match="'nobody' in colors.*soccer"):
        find_file("nobody", "colors")
    with pytest.raises(ValueError, match="'nobody' in camera_models.*soccer_small_size"):
        load_camera_model("nobody")


def test_a_hidden_mask_must_be_a_picture(tmp_path: Path) -> None:
    assert load_hidden_mask("") is None
    with pytest.raises(ValueError, match="not a picture"):
        load_hidden_mask(str(tmp_path / "none.png"))
