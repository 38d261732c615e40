"""What somebody does wrong the first time is said in one line that names it."""

from __future__ import annotations

import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from sim_bridge.config import DriveConfig
from sim_bridge.drive import Velocity, limitation
from sim_bridge.placement import oddities
from sim_bridge.schema import WorldError
from sim_bridge.simulation import Simulation, check_world
from sim_bridge.world import RobotPlacement, Wall, World, load_world

ROBOT = RobotPlacement(model="segway_urg", position_m=(1.0, 1.0))
WALLS = (Wall(from_m=(0, 0), to_m=(4, 0)), Wall(from_m=(4, 0), to_m=(4, 4)))


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(World(name="room", walls=WALLS, robots=(ROBOT,)))


@pytest.mark.parametrize(
    ("commands", "said"),
    [
        ({"r7": Velocity(0.1, 0.0)}, r"robots of the world \(''\), got 'r7'"),
        (Velocity(0.1, 0.0), "must map names of robots to Velocity .*, got Velocity"),
        ({"": (0.1, 0.0)}, r"commands\[''\] must be a Velocity, got tuple"),
    ],
)
def test_a_wrong_command_is_named_and_nothing_moves(simulation, commands, said) -> None:
    before = simulation.stamp_ns
    with pytest.raises(ValueError, match=said):
        simulation.step(commands)
    assert simulation.stamp_ns == before


def test_two_robots_without_names_are_told_to_have_some() -> None:
    with pytest.raises(ValueError, match="several robots need names"):
        World(name="room", robots=(ROBOT, ROBOT))


def test_a_robot_inside_a_wall_is_found_without_building_the_world() -> None:
    inside = RobotPlacement(model="segway_urg", position_m=(2.0, 0.0))
    with pytest.raises(WorldError, match=r"robot \(unnamed\) at \(2, 0\) is inside"):
        check_world(World(name="room", walls=WALLS, robots=(inside,)))
    check_world(World(name="room", walls=WALLS, robots=(ROBOT,)))


def test_a_missing_recording_says_how_to_name_another() -> None:
    with pytest.raises(WorldError, match=r"world_parameters:=\[file=...\]"):
        check_world(load_world("recorded_hotel", {"file": "nowhere.txt"}))


def test_worlds_that_are_hardly_meant_are_said() -> None:
    away = RobotPlacement(model="segway_urg", position_m=(9.0, 1.0))
    assert oddities(World(name="room", walls=WALLS, robots=(ROBOT,))) == []
    assert oddities(World(name="open", robots=(away,))) == []
    (text,) = oddities(World(name="room", walls=WALLS, robots=(away,)))
    assert text == "robot (unnamed) at (9, 1) is outside all walls"
    (text,) = oddities(World(name="room", walls=WALLS))
    assert "no robots" in text


def test_what_a_drive_does_not_do_as_told_is_named() -> None:
    straight, omni = DriveConfig(), DriveConfig(is_omnidirectional=True)
    assert limitation(straight, Velocity(1.667, -1.5)) == ""
    assert limitation(straight, Velocity(2.0, 0.0)) == (
        "travel is clipped to max_speed_m_s, 1.667 m/s"
    )
    assert "linear.y is ignored" in limitation(straight, Velocity(0.1, 0.0, 0.1))
    assert limitation(omni, Velocity(1.0, 0.0, 1.0)) == ""
    assert "travel is clipped" in limitation(omni, Velocity(1.3, 0.0, 1.3))
    assert "angular.z is clipped" in limitation(omni, Velocity(0.0, -1.6))
