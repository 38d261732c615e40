"""World files: what is read, and what is refused with a line that helps."""

from pathlib import Path

import pytest

from sim_bridge.config import SimBridgeConfig
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
        ("name: w\nname: v\n", "'name' is there twice"),
        ("name: w\nlight: {ambient: 0.1, ambient: 0.2}\n", "'ambient' is there twice"),
        ("name: w\nceiling_m: -3\n", "ceiling_m must be > 0"),
        (
            "name: w\ncolumns: [{name: c, center_m: [3, 3], radius_m: 0.1, color: [300, 0, 0]}]\n",
            "from 0 to 1",
        ),
        ("name: w\nfloor: {lines: [{from_m: [0, 0], to_m: [1, 1], color: [0, -1, 0]}]}\n", "color"),
        ("name: w\nroute: {waypoints_m: [[0, 0]], speed_m_s: -1}\n", "speed_m_s must be > 0"),
        ("name: w\nroute: {waypoints_m: []}\n", "waypoints_m"),
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


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"urdf": "nope.urdf"}, "'nope.urdf'"),
        ({"drive": {"is_omnidirectional": True}}, "bearings_deg"),
        ({"wheels": {"bearings_deg": [0, 0, 0]}}, "any way"),
        ({"wheels": {"bearings_deg": [30, 30, 210]}}, "any way"),
        ({"footprint_m": []}, "footprint_m"),
        ({"footprint_m": [[0, 0]]}, "footprint_m"),
        ({"footprint_m": [[0, 0], [1, 0], [2, 0]]}, "convex"),
        ({"footprint_m": [[0, 0], [2, 0], [0.5, 0.5], [0, 2]]}, "convex"),
        ({"height_m": -1}, "height_m"),
        ({"drive": {"command_delay_s": 0.6}}, "command_delay_s"),
        ({"drive": {"max_speed_m_s": 100}}, "max_speed_m_s"),
        ({"laser": {"period_s": 0.001}}, "period_s"),
        ({"odometry": {"period_s": 0.001}}, "period_s"),
        ({"sonar": {"period_s": 0.03}}, "slots"),
    ],
)
def test_a_bad_robot_is_refused_in_one_line(overrides: dict, words: str) -> None:
    placed = RobotPlacement(model="segway_rmp50", position_m=(0.0, 0.0), overrides=overrides)
    with pytest.raises(WorldError, match="robot segway_rmp50: ") as caught:
        load_robot(placed)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("step", [0.015, 0.005, 2.0])
def test_a_step_that_is_no_whole_number_of_steps_or_blocks_long_is_refused(step: float) -> None:
    with pytest.raises(ValueError, match="step_s"):
        SimBridgeConfig(step_s=step)
    assert SimBridgeConfig(step_s=0.07).step_s == 0.07
