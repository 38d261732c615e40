"""People in a simulation: seen by sensors, felt by robots, the same bytes for the same seed."""

import hashlib
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.drive import Velocity
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.schema import Crowd, WalkerPlan
from sim_bridge.robot_model import load_robot
from sim_bridge.schema import WorldError, parsed_parameters
from sim_bridge.simulation import Simulation
from sim_bridge.snapshot import snapshot
from sim_bridge.world import RobotPlacement, World, load_world, world_names

from .conftest import PERFECT, box_room

CROWD = Crowd(num=4, low_m=(3.0, 0.6), high_m=(5.4, 3.4))


def _digest(simulation: Simulation, num_steps: int) -> str:
    digest = hashlib.sha256()
    for k in range(num_steps):
        command = Velocity(0.3, 0.2 * math.sin(0.02 * k))
        seen = simulation.step(dict.fromkeys(simulation.models, command))
        for person in seen.ground_truth_people:
            digest.update(np.array([*person.pose.as_array(), *person.velocity]).tobytes())
        for robot in seen.robots.values():
            digest.update(robot.ground_truth.pose.as_array().tobytes())
            if robot.scan is not None:
                digest.update(robot.scan.ranges.tobytes())
            for reading in robot.sonar or ():
                digest.update(np.float64(reading.range).tobytes())
            if robot.odometry is not None:
                digest.update(robot.odometry.pose.as_array().tobytes())
            if robot.omni is not None:
                digest.update(robot.omni.tobytes())
    return digest.hexdigest()


def _room(*plans: WalkerPlan, crowd: Crowd | None = None, **config: object) -> World:
    model = PeopleConfig(**config)  # type: ignore[arg-type]
    return replace(box_room(PERFECT), people=plans, crowd=crowd, people_model=model)


def _scan_at(simulation: Simulation, num_steps: int) -> tuple:
    seen = [simulation.step({}).robots[""] for _ in range(num_steps)]
    return [s.scan for s in seen if s.scan is not None][-1]


def test_the_laser_sees_two_legs_where_a_person_stands(simulate) -> None:
    person = WalkerPlan(name="a", path_m=((4.0, 1.0), (4.0, 3.0)), starts_s=100.0)
    scan = _scan_at(simulate(_room(person)), 10)
    # The person faces +y: its legs are one behind the other... on x: 3.89 and 4.11, seen from 2.14.
    ahead = scan.ranges[np.abs(scan.angles) < 0.02]
    assert ahead.min() == pytest.approx(4.0 - 0.11 - 0.065 - 2.14, abs=2e-3)


def test_a_person_of_one_piece_is_seen_as_a_round_body(simulate) -> None:
    person = WalkerPlan(name="a", path_m=((4.0, 1.0),))
    scan = _scan_at(simulate(_room(person, has_legs=False)), 10)
    ahead = scan.ranges[np.argmin(np.abs(scan.angles))]
    assert ahead == pytest.approx(4.0 - 0.2 - 2.14, abs=2e-3)


def test_a_sonar_hears_a_person_of_one_piece(simulate) -> None:
    person = WalkerPlan(name="a", path_m=((3.2, 1.0),))
    simulation = simulate(_room(person, has_legs=False))
    readings = [simulation.step({}).robots[""].sonar for _ in range(40)]
    front = [r[0].range for r in readings if r is not None and not math.isnan(r[0].range)]
    assert front[-1] == pytest.approx(3.2 - 0.2 - 2.2, abs=0.05)


def test_a_walker_that_does_not_heed_the_robot_touches_it(simulate) -> None:
    person = WalkerPlan(name="a", path_m=((4.0, 1.0), (2.0, 1.0)), speed_m_s=1.0)
    simulation = simulate(_room(person))
    touched = [simulation.step({}).robots[""].ground_truth.is_touching for _ in range(250)]
    assert not touched[100] and any(touched)


def test_same_seed_same_bytes_with_a_crowd_and_another_seed_others(simulate) -> None:
    worlds = [simulate(replace(box_room(), crowd=CROWD), seed=seed) for seed in (7, 7, 8)]
    first, second, other = (_digest(simulation, 200) for simulation in worlds)
    assert first == second != other


def test_reset_brings_robots_people_and_pushed_boxes_back_byte_for_byte(simulate) -> None:
    world = load_world("crowd")
    simulation = simulate(world, seed=3)
    first = _digest(simulation, 300)
    simulation.reset()
    assert _digest(simulation, 300) == first


def test_two_robots_and_their_sensors_repeat_after_reset(simulate) -> None:
    robots = tuple(
        RobotPlacement(model="segway_rmp50", name=n, position_m=p, yaw_deg=yaw)
        for n, p, yaw in (("a", (1.2, 2.0), 0.0), ("b", (3.4, 2.0), 180.0))
    )
    simulation = simulate(replace(box_room(), robots=robots), seed=5)
    first = _digest(simulation, 500)
    assert any(r.ground_truth.is_touching for r in simulation.step({}).robots.values())
    simulation.reset()
    assert _digest(simulation, 500) == first


def test_one_robot_more_changes_no_noise_of_the_others(simulate) -> None:
    a = RobotPlacement(model="segway_rmp50", name="a", position_m=(1.2, 2.0))
    b = RobotPlacement(model="segway_rmp50", name="b", position_m=(1.2, 3.3))
    alone = simulate(replace(box_room(), robots=(a,)), seed=5)
    both = simulate(replace(box_room(), robots=(a, b)), seed=5)
    drive = Velocity(0.3, 0.0)
    for _ in range(100):
        one = alone.step({"a": drive}).robots["a"]
        two = both.step({"a": drive}).robots["a"]
    assert one.odometry.pose == two.odometry.pose
    assert one.ground_truth.pose.between(two.ground_truth.pose).distance < 1e-9


def test_moving_world_robot_and_people_together_changes_nothing(simulate) -> None:
    T = SE2(-3.0, 5.0, 2.1)
    world = replace(box_room(PERFECT), crowd=CROWD)
    here, there = simulate(world, seed=2), simulate(world, seed=2, T_new_old=T)
    for _ in range(200):
        one, two = (s.step({"": Velocity(0.3, 0.2)}) for s in (here, there))
    for a, b in zip(one.ground_truth_people, two.ground_truth_people, strict=True):
        off = (T @ a.pose).between(b.pose)
        assert off.distance < 1e-6 and abs(off.yaw) < 1e-6
    assert np.allclose(one.robots[""].scan.ranges, two.robots[""].scan.ranges, atol=1e-4)


def test_sjmc_crossing_moves_1_5_m_towards_the_robot_and_1_8_m_across(simulate) -> None:
    world = load_world("sjmc_crossing", {"distance_m": 2.0})
    robot = replace(world.robots[0], overrides={"laser": PERFECT["laser"]})
    simulation = simulate(replace(world, robots=(robot,)))
    people, sensed = [], []
    for _ in range(700):
        seen = simulation.step({"": Velocity(0.8, 0.0)})
        robot = seen.robots[""]
        people.append(seen.ground_truth_people[0].pose)
        if robot.scan is not None and people[-1].y == people[0].y:
            points = robot.ground_truth.pose @ (robot.scan.points() + [0.10, 0.0])
            near = np.hypot(points[:, 0], points[:, 1] + 0.9) < 0.3
            sensed.append(np.nanmin(robot.scan.ranges[robot.scan.is_hit][near], initial=9.0))
    # The last scan before it set out is up to 0.1 s old, at 0.8 m/s.
    assert sensed[-1] == pytest.approx(2.0 + 0.04, abs=0.06)
    assert people[-1].x - people[0].x == pytest.approx(1.5)
    assert people[-1].y - people[0].y == pytest.approx(1.8)


@pytest.mark.parametrize(("never", "is_clear"), [(False, True), (True, False)])
def test_sjmc_oncoming_steps_aside_if_the_robot_is_noticed(simulate, never, is_clear) -> None:
    simulation = simulate(load_world("sjmc_oncoming", {"never_notices": never}))
    touched = False
    for _ in range(800):
        seen = simulation.step({"": Velocity(0.6, 0.0)})
        touched |= seen.robots[""].ground_truth.is_touching
    assert touched != is_clear
    assert seen.ground_truth_people[0].has_noticed != never


@pytest.mark.parametrize("distance", [2.7, 3.7])
def test_the_start_distance_of_the_static_set_up_is_what_the_laser_reads(distance: float) -> None:
    world = load_world("sjmc_static", {"start_distance_m": distance})
    robot = replace(world.robots[0], overrides={"laser": PERFECT["laser"]})
    seen = snapshot(replace(world, robots=(robot,)), robot.pose)
    ahead = seen.scan.ranges[np.argmin(np.abs(seen.scan.angles))]
    assert ahead == pytest.approx(distance, abs=2e-3)


def test_the_urg_errs_by_a_centimeter_or_a_hundredth_of_the_range_in_two_deviations() -> None:
    laser = load_robot(load_world("sjmc_static").robots[0]).config.laser
    for distance, bound in ((0.5, 0.01), (2.0, 0.02), (4.0, 0.04)):
        sd = math.hypot(laser.noise_sd_m, laser.noise_sd_share * distance)
        assert 2.0 * sd == pytest.approx(bound, rel=0.1)


def test_world_parameters_are_read_and_checked() -> None:
    assert parsed_parameters(["a=2.7", "b = true", "file=x/y.txt"]) == {
        "a": 2.7, "b": True, "file": "x/y.txt",
    }  # fmt: skip
    for bad in ("a", "=2", "a="):
        with pytest.raises(WorldError, match="name=value"):
            parsed_parameters([bad])
    with pytest.raises(WorldError, match="there are: start_distance_m"):
        load_world("sjmc_static", {"distance": 2.0})


def test_a_recording_that_is_not_there_is_named(tmp_path: Path) -> None:
    world = load_world("recorded_hotel", {"file": str(tmp_path / "none.txt")})
    with pytest.raises(WorldError, match="none.txt: No such file"):
        Simulation(world)


def test_recorded_people_come_and_go(simulate, tmp_path: Path) -> None:
    file = tmp_path / "obsmat.txt"
    rows = [(25, 1, -1.0), (50, 1, 1.0), (60, 2, 0.0), (70, 2, 0.5)]
    file.write_text("".join(f"{f} {i} {x} 0 -8 0 0 0\n" for f, i, x in rows))
    simulation = simulate(load_world("recorded_hotel", {"file": str(file), "starts_s": 0.0}))
    seen = [simulation.step({}) for _ in range(300)]
    names = [[p.name for p in s.ground_truth_people] for s in seen]
    assert [names[k] for k in (49, 149, 219)] == [[], ["recorded 1"], []]
    assert names[249] == ["recorded 2"]
    assert seen[149].ground_truth_people[0].pose.x == pytest.approx(0.0, abs=0.02)


def test_people_and_robots_with_one_name_are_refused() -> None:
    plan = WalkerPlan(name="a", path_m=((0.0, 0.0),))
    with pytest.raises(ValueError, match="two people"):
        World(name="w", people=(plan, plan))
    with pytest.raises(ValueError, match="letter first"):
        RobotPlacement(model="m", position_m=(0, 0), name="1 r")


def test_robots_inside_each_other_are_refused() -> None:
    robots = tuple(
        RobotPlacement(model="segway_rmp50", name=n, position_m=(2.0, y))
        for n, y in (("a", 1.0), ("b", 1.3))
    )
    with pytest.raises(WorldError, match="robot b at .* is inside robot a"):
        Simulation(replace(box_room(), robots=robots))


@pytest.mark.parametrize("name", [n for n in world_names() if n != "recorded_hotel"])
def test_every_world_of_the_package_runs(simulate, name: str) -> None:
    simulation = simulate(load_world(name))
    seen = [simulation.step({}) for _ in range(12)]
    assert simulation.models and all(
        not robot.ground_truth.is_touching for robot in seen[-1].robots.values()
    )
