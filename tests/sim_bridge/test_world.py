"""World files: what is read, and what is refused with a line that helps."""

from pathlib import Path

import pytest

from sim_bridge.robot_model import load_robot
from sim_bridge.schema import WorldError
from sim_bridge.world import RobotPlacement, load_world, world_names

ROBOT = "robots: [{model: segway_rmp50, position_m: [0, 0]}]\n"


def _write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "w.yaml"
    path.write_text(text)
    return path


def test_the_packaged_worlds_load() -> None:
    assert "furnished_floor" in world_names()
    world = load_world("furnished_floor")
    assert world.route is not None and len(world.walls) == 10


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: w\nwals: []\n", "unknown key 'wals'"),
        ("walls: []\n", "'name' is missing"),
        ("name: w\nwalls: [{from_m: [1, 2], to_m: [1, 2]}]\n", "zero length"),
        ("name: w\nwalls: [{from_m: [1, 2], to_m: [.nan, 2]}]\n", "finite"),
        ("name: w\nwalls: [{from_m: [1], to_m: [1, 2]}]\n", "expected 2 values"),
        ("name: w\nwalls: [{from_m: [0, 0], to_m: [1, 0], doors: [{at_m: 3}]}]\n", "leaves"),
        ("name: w\ncolumns: [{name: c, center_m: [0, 0], radius_m: 0}]\n", "radius_m"),
        (
            "name: w\nrobots: [{model: m, position_m: [0, 0]}, {model: m, position_m: [9, 0]}]\n",
            "several robots need names",
        ),
        ("- 1\n", "expected a mapping"),
        ("name: [\n", "not YAML"),
    ],
)
def test_a_bad_file_is_refused_in_one_line_with_its_place(
    tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises(WorldError) as caught:
        load_world(_write(tmp_path, text))
    assert words in str(caught.value)
    assert "w.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_world_names_those_there_are() -> None:
    with pytest.raises(WorldError, match="furnished_floor"):
        load_world("nowhere")


def test_a_missing_file_is_named() -> None:
    with pytest.raises(WorldError, match="no/such.yaml"):
        load_world("no/such.yaml")


def test_an_unknown_robot_names_those_there_are() -> None:
    with pytest.raises(WorldError, match="segway_rmp50"):
        load_robot(RobotPlacement(model="segwy", position_m=(0.0, 0.0)))


def test_overrides_change_single_keys_and_are_checked() -> None:
    wide = RobotPlacement(
        model="segway_rmp50", position_m=(0.0, 0.0), overrides={"laser": {"num_beams": 1081}}
    )
    laser = load_robot(wide).config.laser
    assert laser is not None and laser.num_beams == 1081
    bad = RobotPlacement(
        model="segway_rmp50", position_m=(0.0, 0.0), overrides={"laser": {"beams": 1}}
    )
    with pytest.raises(WorldError, match="unknown key 'beams'"):
        load_robot(bad)
