"""Robots against things: every robot stops at all that stands, and is not moved by people."""

import math
from typing import Any

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.drive import Velocity
from sim_bridge.floor_motion import on_its_way
from sim_bridge.glass import Glass
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.robot_model import load_robot, robot_names
from sim_bridge.world import Furniture, RobotPlacement, Wall, World

BLIND: dict[str, Any] = {"laser": None, "sonar": None, "omni": None, "stereo": None}
TOL_M = 0.015
MIDDLE = 2.0


def _robot(model: str, x: float, name: str = "", **overrides: Any) -> RobotPlacement:
    return RobotPlacement(
        model=model, name=name, position_m=(x, 0.0), overrides={**BLIND, **overrides}
    )


def _farthest(simulation, command: Velocity, num_steps: int, name: str = "") -> float:
    """Return how far along x the robot's middle ever came."""
    xs = []
    for _ in range(num_steps):
        seen = simulation.step({name: command})
        xs.append(seen.robots[name].ground_truth.pose.x)
    assert seen.robots[name].ground_truth.is_touching
    return max(xs)


def _front(model: str) -> float:
    return float(np.array(load_robot(_robot(model, 0.0)).config.footprint_m)[:, 0].max())


def _rated(model: str) -> float:
    return load_robot(_robot(model, 0.0)).config.drive.max_speed_m_s


def _obstacle(kind: str) -> dict[str, Any]:
    ends: dict[str, Any] = {"from_m": (MIDDLE, -3.0), "to_m": (MIDDLE, 3.0)}
    if kind == "pane":
        return {"walls": (Wall(**ends, glass=Glass(thickness_m=0.008)),)}
    return {"walls": (Wall(**ends, thickness_m=0.12),)}


@pytest.mark.parametrize("model", robot_names())
@pytest.mark.parametrize(("kind", "thickness"), [("pane", 0.008), ("wall", 0.12)])
def test_a_wall_stops_every_robot_at_rated_speed(simulate, model, kind, thickness) -> None:
    speed = _rated(model)
    start = MIDDLE - _front(model) - 0.6 - speed**2
    simulation = simulate(World(name="w", robots=(_robot(model, start),), **_obstacle(kind)))
    came = _farthest(simulation, Velocity(speed, 0.0), 100 + round(100 * (5.0 + speed)))
    assert came == pytest.approx(MIDDLE - thickness / 2.0 - _front(model), abs=TOL_M)


@pytest.mark.parametrize("model", robot_names())
def test_a_standing_person_stops_every_robot_at_rated_speed(simulate, model) -> None:
    speed = _rated(model)
    start = MIDDLE - _front(model) - 0.6 - speed**2
    person = WalkerPlan(name="p", path_m=((MIDDLE, 0.11),))  # a leg straight ahead
    simulation = simulate(World(name="w", robots=(_robot(model, start),), people=(person,)))
    came = _farthest(simulation, Velocity(speed, 0.0), 100 + round(100 * (5.0 + speed)))
    stopped_by_leg = MIDDLE - 0.065 - _front(model)
    # Its mast, 0.14 m ahead and 0.07 m beside the middle of the torso, meets that first.
    stopped_by_torso = MIDDLE - math.sqrt(0.2**2 - 0.07**2) - 0.14
    expected = stopped_by_torso if model == "segway_urg" else stopped_by_leg
    assert came == pytest.approx(expected, abs=TOL_M)


@pytest.mark.parametrize("model", robot_names())
def test_robots_of_a_kind_do_not_drive_into_each_other(simulate, model) -> None:
    speed = _rated(model)
    corners = np.array(load_robot(_robot(model, 0.0)).config.footprint_m)
    apart = float(corners[:, 0].max() - corners[:, 0].min())
    start = MIDDLE - apart - 0.6 - speed**2
    robots = (_robot(model, start, "a"), _robot(model, MIDDLE, "b"))
    simulation = simulate(World(name="w", robots=robots))
    nearest, was_touching = math.inf, False
    for _ in range(100 + round(100 * (5.0 + speed))):
        seen = simulation.step({"a": Velocity(speed, 0.0), "b": Velocity(0.0, 0.0)}).robots
        a, b = (seen[name].ground_truth.pose for name in "ab")
        nearest = min(nearest, math.hypot(b.x - a.x, b.y - a.y))
        was_touching |= seen["a"].ground_truth.is_touching
    assert was_touching
    assert nearest == pytest.approx(apart, abs=TOL_M)


@pytest.mark.parametrize("speed", [3.0, 20.0])
def test_nothing_is_too_fast_for_the_thinnest_pane(simulate, speed: float) -> None:
    drive = {"max_speed_m_s": speed, "max_accel_m_s2": 200.0}
    wall = Wall(from_m=(MIDDLE, -3.0), to_m=(MIDDLE, 3.0), glass=Glass(thickness_m=0.003))
    robot = _robot("soccer_small_size", -1.0, drive=drive)
    simulation = simulate(World(name="w", walls=(wall,), robots=(robot,)))
    came = _farthest(simulation, Velocity(speed, 0.0), 150)
    assert came == pytest.approx(MIDDLE - 0.0015 - 0.085, abs=TOL_M)


def test_a_robot_that_slides_sideways_is_stopped_too(simulate) -> None:
    wall = Wall(from_m=(-5.0, 1.0), to_m=(5.0, 1.0), glass=Glass())
    simulation = simulate(World(name="w", walls=(wall,), robots=(_robot("soccer_middle_size", 0),)))
    for _ in range(300):
        pose = simulation.step({"": Velocity(0.0, 0.0, 1.0)}).robots[""].ground_truth.pose
    assert pose.y == pytest.approx(1.0 - 0.004 - 0.2, abs=TOL_M)


def test_a_walker_who_heeds_nothing_does_not_move_a_standing_robot(simulate) -> None:
    walker = WalkerPlan(name="p", path_m=((1.5, 0.1), (-1.5, 0.1)), speed_m_s=1.2)
    robot = _robot("segway_rmp50", 0.0)
    simulation = simulate(World(name="w", people=(walker,), robots=(robot,)))
    touched = 0
    for _ in range(300):
        truth = simulation.step({"": Velocity(0.0, 0.0)}).robots[""].ground_truth
        touched += truth.is_touching
    assert touched > 20
    assert np.abs(truth.pose.as_array()).max() < 1e-12


def test_a_robot_leaves_a_person_who_walked_into_it(simulate) -> None:
    walker = WalkerPlan(name="p", path_m=((1.5, 0.0), (0.15, 0.0)), speed_m_s=1.2)
    simulation = simulate(World(name="w", people=(walker,), robots=(_robot("segway_rmp50", 0.0),)))
    for _ in range(200):
        simulation.step({"": Velocity(0.0, 0.0)})
    for _ in range(200):
        truth = simulation.step({"": Velocity(-0.5, 0.0)}).robots[""].ground_truth
    assert truth.pose.x < -0.5 and not truth.is_touching


def test_contact_only_shortens_the_way_by_hand() -> None:
    before, wanted = SE2(1.0, 2.0, 0.3), np.array([0.02, 0.0, 0.1])
    half = on_its_way(before, SE2(1.01, 2.5, 0.35), wanted)
    assert half.as_array() == pytest.approx([1.01, 2.0, 0.35])
    back = on_its_way(before, SE2(0.5, 2.0, 0.2), wanted)
    assert back.as_array() == pytest.approx([1.0, 2.0, 0.3])
    shoved = on_its_way(before, SE2(3.0, 2.0, 1.0), wanted)
    assert shoved.as_array() == pytest.approx([1.02, 2.0, 0.4])


def test_reset_is_byte_for_byte_with_a_box_that_is_pushed_against_a_wall(simulate) -> None:
    box = Furniture(name="light", center_m=(0.9, 0.3), size_m=(0.3, 0.3, 0.5), mass_kg=3.0)
    wall = Wall(from_m=(MIDDLE, -5.0), to_m=(MIDDLE, 5.0))
    robot = RobotPlacement(model="segway_rmp50", position_m=(0.0, 0.0), yaw_deg=20.0)
    world = World(name="w", walls=(wall,), boxes=(box,), robots=(robot,))
    simulation = simulate(world, seed=4)

    def run() -> tuple[list[bytes], bool]:
        told, touched = [], False
        for _ in range(300):
            seen = simulation.step({"": Velocity(0.8, 0.0)}).robots[""]
            told.append(seen.ground_truth.pose.as_array().tobytes())
            told += [] if seen.scan is None else [seen.scan.ranges.tobytes()]
            told += [] if seen.sonar is None else [repr(seen.sonar).encode()]
            touched |= seen.ground_truth.is_touching
        return told, touched

    first, touched = run()
    assert touched
    for _ in range(2):
        simulation.reset()
        assert run()[0] == first
    assert simulation._physics._engine.getNumBodies(simulation._physics._client) == 4
