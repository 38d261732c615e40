"""The command that writes a floor's color."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from painted_floors import BROWN, GRAY, GREEN, WHITE, behind, painted, robot_body, upright_camera

from floor_perception.color_files import load_color
from floor_perception.color_model import chromaticity
from floor_perception.config import CameraNodeConfig, FloorDetectorConfig
from floor_perception.learn_colors import main
from floor_perception.polar_template import make_template
from floor_perception.resources import load_camera_model
from floornav_common.config_files import config_from_mapping
from floornav_common.reporting import UserError

CONFIGS = Path(__file__).parents[2] / "ros_ws" / "src" / "floor_perception" / "parameters"


def saved(path: Path, picture: np.ndarray) -> str:
    assert cv2.imwrite(str(path), picture[..., ::-1])
    return str(path)


@pytest.fixture
def floor(tmp_path: Path) -> str:
    """Return a picture of a green floor with a wall that the robot touches."""
    regions = [(behind(0.0, 1.2, 0.1), WHITE), (robot_body(), GRAY)]
    return saved(tmp_path / "floor.png", painted(upright_camera(), regions, 2.0))


def test_the_color_around_the_robot_is_written(floor: str, tmp_path: Path) -> None:
    out = tmp_path / "new" / "color.yaml"
    assert main([floor, floor, "--out", str(out)]) == 0
    assert load_color(out).chroma == pytest.approx(chromaticity(np.array(GREEN)), abs=0.01)


def test_a_box_needs_no_camera(tmp_path: Path) -> None:
    picture = np.full((40, 60, 3), WHITE, np.uint8)
    picture[10:30, 20:50] = BROWN
    path, out = saved(tmp_path / "any.png", picture), tmp_path / "color.yaml"
    assert main([path, "--box", "20", "10", "50", "30", "--out", str(out)]) == 0
    assert load_color(out).chroma == pytest.approx(chromaticity(np.array(BROWN)), abs=0.01)


def test_a_file_that_exists_is_left_alone(floor: str, tmp_path: Path) -> None:
    out = tmp_path / "color.yaml"
    out.write_text("mine")
    with pytest.raises(UserError, match="exists"):
        main([floor, "--out", str(out)])
    assert out.read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nobody.png"], "nobody.png is not a picture"),
        (["FLOOR", "--box", "0", "0", "9999", "2"], "--box must lie within 256 x 220"),
        (["FLOOR", "--camera-model", "nobody"], "no file named 'nobody'"),
    ],
)
def test_bad_input_is_named(floor: str, tmp_path: Path, words: list[str], said: str) -> None:
    words = [floor if word == "FLOOR" else word for word in words]
    with pytest.raises(UserError, match=said):
        main([*words, "--out", str(tmp_path / "color.yaml")])


def test_no_file_is_written_where_no_color_prevails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = np.full((40, 45, 3), GREEN, np.uint8)
    picture[:, 15:30], picture[:, 30:] = BROWN, WHITE
    path, out = saved(tmp_path / "thirds.png", picture), tmp_path / "color.yaml"
    assert main([path, "--box", "0", "0", "45", "40", "--out", str(out)]) == 1
    assert "share a color" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda p: p.stem)
def test_every_parameter_file_fits_config_and_camera(path: Path) -> None:
    (values,) = (node["ros__parameters"] for node in yaml.safe_load(path.read_text()).values())
    camera = CameraNodeConfig(camera_model=values.pop("camera_model")).camera_model
    flat = {f"{group}.{k}": v for group, keys in values.items() for k, v in keys.items()}
    config = config_from_mapping(FloorDetectorConfig, flat)
    template = make_template(load_camera_model(camera), config.template)
    assert template.edges[0] == pytest.approx(values["template"]["range_min_m"])
    assert template.edges[-1] == pytest.approx(values["template"]["horizon_m"])
