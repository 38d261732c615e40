"""Laws of the simulation: rays by hand, repeatability, symmetry, dead reckoning, bad commands."""

import hashlib
import math
from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.drive import Velocity
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.ranging import is_due, sensor_stream
from sim_bridge.schema import WorldError
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.world import RobotPlacement, Wall, World, load_world

from .conftest import PERFECT, box_room

TOL_M = 1e-4
LASER_X = 0.14
CURVE = Velocity(0.5, 0.3)


def _drive(simulation: Simulation, num_steps: int, command: Velocity = CURVE) -> list:
    name = next(iter(simulation.models))
    return [simulation.step({name: command}).robots[name] for _ in range(num_steps)]


def _scan(observations: list) -> np.ndarray:
    return [seen.scan for seen in observations if seen.scan is not None][-1]


def _bytes(observations: list) -> str:
    digest = hashlib.sha256()
    for seen in observations:
        digest.update(seen.ground_truth.pose.as_array().tobytes())
        if seen.odometry is not None:
            digest.update(seen.odometry.pose.as_array().tobytes())
            digest.update(seen.odometry.cov.tobytes())
        if seen.scan is not None:
            digest.update(seen.scan.ranges.tobytes())
    return digest.hexdigest()


def test_ranges_in_a_box_room_are_those_computed_by_hand(simulate) -> None:
    scan = _scan(_drive(simulate(box_room(PERFECT)), 10, Velocity(0.0, 0.0)))
    x, y = 2.0 + LASER_X, 1.0
    to_x = [((6.0 if c > 0 else 0.0) - x) / c for c in np.cos(scan.angles)]
    to_y = [((4.0 if s > 0 else 0.0) - y) / s if s else math.inf for s in np.sin(scan.angles)]
    assert np.allclose(scan.ranges, np.minimum(to_x, to_y), atol=TOL_M)


def test_same_seed_gives_the_same_bytes(simulate) -> None:
    runs = [_bytes(_drive(simulate(box_room(), seed=7), 200)) for _ in range(2)]
    assert runs[0] == runs[1]


def test_another_seed_gives_other_bytes(simulate) -> None:
    runs = [_bytes(_drive(simulate(box_room(), seed=seed), 50)) for seed in (1, 2)]
    assert runs[0] != runs[1]


def test_reset_brings_everything_back(simulate) -> None:
    simulation = simulate(box_room(), seed=3)
    first = _bytes(_drive(simulation, 150))
    simulation.reset()
    assert simulation.stamp_ns == 0
    assert _bytes(_drive(simulation, 150)) == first


def test_odometry_integrates_to_the_truth_without_noise(simulate) -> None:
    simulation = simulate(box_room(PERFECT))
    start = SE2(2.0, 1.0, 0.0)
    last = _drive(simulation, 400)[-1]
    moved = start.between(last.ground_truth.pose)
    assert moved.distance > 1.0
    off = moved.between(last.odometry.pose)
    # An interval of odometry is taken as one arc, also while the robot accelerates.
    assert off.distance < 1e-5 and abs(off.yaw) < 1e-9


def test_moving_world_and_robot_together_changes_nothing(simulate) -> None:
    T = SE2(-3.0, 5.0, 2.1)
    here = _drive(simulate(box_room(PERFECT)), 300)
    there = _drive(simulate(box_room(PERFECT), T_new_old=T), 300)
    assert np.allclose(_scan(here).ranges, _scan(there).ranges, atol=TOL_M)
    off = (T @ here[-1].ground_truth.pose).between(there[-1].ground_truth.pose)
    assert off.distance < 1e-9 and abs(off.yaw) < 1e-9


def test_odometry_drifts_with_noise_about_as_far_as_it_claims(simulate) -> None:
    simulation = simulate(box_room())
    yaw_errors, claimed = [], 0.0
    for seed in range(12):
        simulation.reset(seed)
        last = _drive(simulation, 900, Velocity(0.6, 0.9))[-1]
        error = last.ground_truth.pose.yaw - last.odometry.pose.yaw
        yaw_errors.append(math.remainder(error, 2.0 * math.pi))
        claimed = math.sqrt(last.odometry.cov[2, 2])
    assert 0.3 * claimed < np.std(yaw_errors) < 2.0 * claimed


def test_a_wall_stops_the_robot_but_not_its_wheels(simulate) -> None:
    last = _drive(simulate(box_room(PERFECT)), 1000, Velocity(0.8, 0.0))[-1]
    assert last.ground_truth.is_touching
    assert last.ground_truth.pose.x == pytest.approx(6.0 - 0.20, abs=0.03)
    assert last.odometry.pose.x > 6.0


def test_the_robot_stops_when_commands_stop(simulate) -> None:
    simulation = simulate(box_room(PERFECT))
    _drive(simulation, 100, Velocity(0.4, 0.0))
    later = [simulation.step({}).robots[""] for _ in range(120)]
    assert later[45].ground_truth.velocity.speed == pytest.approx(0.4, abs=1e-6)
    assert later[-1].ground_truth.velocity.speed == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e6])
def test_a_bad_command_is_named_and_stops_the_robot(simulate, bad: float) -> None:
    simulation = simulate(box_room(PERFECT))
    _drive(simulation, 60, Velocity(0.4, 0.0))
    seen = _drive(simulation, 1, Velocity(bad, 0.0))[0]
    assert "linear.x" in seen.refused
    later = [simulation.step({}).robots[""] for _ in range(60)]
    assert later[-1].ground_truth.velocity.speed == pytest.approx(0.0, abs=1e-9)
    assert math.isfinite(later[-1].ground_truth.pose.x)


def test_robots_see_each_other_but_not_themselves(simulate) -> None:
    base = box_room(PERFECT)
    robots = tuple(
        RobotPlacement(model="segway_rmp50", name=n, position_m=p, overrides=PERFECT)
        for n, p in (("a", (1.0, 2.0)), ("b", (4.0, 2.0)))
    )
    world = World(name="two", walls=base.walls, robots=robots)
    simulation = simulate(world)
    seen = [simulation.step({}) for _ in range(10)][-1]
    scan = seen.robots["a"].scan
    ahead = scan.ranges[np.argmin(np.abs(scan.angles))]
    assert ahead == pytest.approx(4.0 - 0.49 - 1.0 - LASER_X, abs=0.01)


def test_a_robot_inside_a_wall_is_refused() -> None:
    with pytest.raises(WorldError, match="inside 'wall'"):
        Simulation(box_room(pose=SE2(0.2, 1.0, 0.0)))


def test_every_world_of_the_package_starts(simulate) -> None:
    simulation = simulate(load_world("furnished_floor"))
    assert _scan(_drive(simulation, 10)).is_hit.mean() > 0.9


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"people": (WalkerPlan(name="p", path_m=((6.05, 2.0),)),)}, "person 'p' .* in 'wall'"),
        ({"people": (WalkerPlan(name="p", path_m=((2.0, 1.0),)),)}, "person 'p' .* in robot"),
        ({"people": (WalkerPlan(name="p", path_m=((2.35, 1.0),)),)}, "person 'p' .* in robot"),
        (
            {"robots": (RobotPlacement(model="segway_rmp50", position_m=(200.0, 0.0)),)},
            "off the floor",
        ),
    ],
)
def test_nobody_starts_inside_anything_or_off_the_floor(changes: dict, words: str) -> None:
    with pytest.raises(WorldError, match=words):
        Simulation(replace(box_room(), **changes))


def test_forty_robots_run_and_none_sees_itself_or_passes_a_wall(simulate) -> None:
    blind = {**PERFECT, "sonar": None, "laser": None}
    seeing = {**PERFECT, "sonar": None}
    wall = Wall(from_m=(2.0, -45.0), to_m=(2.0, 45.0))
    robots = tuple(
        RobotPlacement(
            model="segway_rmp50", name=f"r{k}", position_m=(1.2, 2.0 * k - 40.0),
            overrides=seeing if k in (0, 39) else blind,
        )
        for k in range(40)
    )  # fmt: skip
    simulation = simulate(World(name="many", walls=(wall,), robots=robots))
    commands = dict.fromkeys(simulation.models, Velocity(0.8, 0.0))
    for _ in range(160):
        seen = simulation.step(commands).robots
    assert all(robot.ground_truth.pose.x < 1.76 for robot in seen.values())
    for name in ("r0", "r39"):
        ahead = seen[name].scan.ranges[len(seen[name].scan.ranges) // 2]
        x = seen[name].ground_truth.pose.x + LASER_X
        assert ahead == pytest.approx(1.94 - x, abs=1e-3)


def test_no_two_robots_or_sensors_share_their_noise() -> None:
    draws = {
        (robot, sensor): tuple(sensor_stream(7, robot, sensor).standard_normal(4))
        for robot in ("a", "b", "")
        for sensor in ("laser", "laser glass", "sonar")
    }
    assert len(set(draws.values())) == len(draws)


def test_laser_noise_of_two_robots_in_the_same_place_is_independent(simulate) -> None:
    def ranges(name: str) -> np.ndarray:
        robot = replace(box_room().robots[0], name=name)
        simulation = simulate(replace(box_room(), robots=(robot,)), seed=3)
        return [simulation.step({}).robots[name].scan for _ in range(10)][-1].ranges

    a, b = ranges("a"), ranges("b")
    off = (a - b)[np.isfinite(a) & np.isfinite(b)]
    assert len(off) > 400
    middle = np.percentile(np.abs(off), 50)  # edges left out
    assert middle == pytest.approx(0.6745 * 0.01 * math.sqrt(2.0), rel=0.2)


@pytest.mark.parametrize(("period_s", "gaps"), [(0.02, {2}), (0.033, {3, 4}), (0.01, {1})])
def test_what_is_due_comes_at_its_rate_whatever_the_period(period_s: float, gaps: set) -> None:
    due = [k for k in range(1, 1000) if is_due(k * STEP_NS, period_s, STEP_NS)]
    assert set(np.diff(due)) == gaps
    assert len(due) == pytest.approx(9.99 / period_s, abs=1.0)
