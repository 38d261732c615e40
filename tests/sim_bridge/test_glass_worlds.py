"""Glass in worlds: what stands where, the papers' lengths, what each sensor makes of it."""

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.glass import Frame, Glass
from sim_bridge.measures import Measure
from sim_bridge.schema import WorldError, build
from sim_bridge.snapshot import snapshot
from sim_bridge.solids import solids_of
from sim_bridge.world import Door, Furniture, RobotPlacement, Wall, World, load_world

from .conftest import PERFECT, box_room

TOL_M = 0.002
HALF_WIDTH_M = 0.28
EXACT_SONAR = {
    "noise_sd_m": 0.0, "noise_sd_share": 0.0, "quantum_m": 0.0, "miss_share": 0.0,
    "critical_sd_rad": 0.0,
}  # fmt: skip
ROUTES = ("glass_corridor", "glass_wall", "flat", "office")


def _room_with_glass_at_4(**glass: float) -> World:
    """Return the box room with a pane across it at x = 4 (near face), 2 m before the wall."""
    material = Glass(thickness_m=0.01, **glass)
    pane = Wall(from_m=(4.005, 0.0), to_m=(4.005, 4.0), glass=material)
    world = box_room({**PERFECT, "sonar": EXACT_SONAR}, SE2(2.0, 2.0, 0.0))
    return replace(world, walls=(*world.walls, pane))


def _ahead(seen) -> float:
    return float(seen.scan.ranges[np.argmin(np.abs(seen.scan.angles))])


def test_a_laser_sees_the_wall_behind_glass_and_a_sonar_the_glass() -> None:
    world = _room_with_glass_at_4(specular_share=0.0, scatter_share=0.0, refractive_index=1.5)
    seen = snapshot(world, SE2(2.0, 2.0, 0.0))
    assert _ahead(seen) == pytest.approx(6.0 - 2.14 + 0.005, abs=TOL_M)
    assert seen.sonar[0].range == pytest.approx(4.0 - 2.2, abs=TOL_M)


def test_a_laser_sees_glass_only_along_its_normal() -> None:
    seen = snapshot(_room_with_glass_at_4(specular_share=1.0, scatter_share=0.0), SE2(2, 2, 0))
    assert _ahead(seen) == pytest.approx(4.0 - 2.14, abs=TOL_M)
    x = 2.14 + seen.scan.ranges * np.cos(seen.scan.angles)
    y = seen.scan.ranges * np.sin(seen.scan.angles)
    is_on_glass = (np.abs(x - 4.0) < 0.01) & (np.abs(y) < 1.9)
    assert np.abs(np.degrees(seen.scan.angles[is_on_glass])).max() < 16.0
    assert (np.abs(x - 6.0) < 0.02).sum() > 30


def test_glass_changes_none_of_the_lasers_own_noise() -> None:
    def scan(walls: tuple[Wall, ...]):
        overrides = {"laser": {"edge_share": 0.0, "quantum_m": 0.0}}
        world = box_room(overrides, SE2(2.0, 2.0, 0.0))
        return snapshot(replace(world, walls=(*world.walls, *walls)), SE2(2, 2, 0), 3).scan

    pane = Wall(from_m=(4.0, 0.0), to_m=(4.0, 4.0), glass=Glass())
    clear, glazed = scan(()), scan((pane,))
    behind = np.abs(clear.angles) > 2.0
    assert np.array_equal(clear.ranges[behind], glazed.ranges[behind], equal_nan=True)


def test_a_glass_wall_has_posts_rails_and_panes_between() -> None:
    frame = Frame(spacing_m=1.0, width_m=0.1, depth_m=0.08, rail_m=0.2)
    wall = Wall(from_m=(0, 0), to_m=(3, 0), glass=Glass(thickness_m=0.01), frame=frame)
    solids = solids_of(World(name="w", walls=(wall,)))
    panes = [s for s in solids if s.glass is not None]
    posts = [s for s in solids if s.glass is None and s.size[2] == wall.height_m]
    assert [p.pose.x for p in posts] == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert [p.pose.x for p in panes] == pytest.approx([0.5, 1.5, 2.5])
    assert panes[0].size == pytest.approx((0.9, 0.01, 2.0)) and panes[0].bottom == 0.2


def test_a_door_of_glass_closes_its_opening() -> None:
    wall = Wall(from_m=(0, 0), to_m=(4, 0), doors=(Door(at_m=2.0, width_m=1.0, glass=Glass()),))
    panes = [s for s in solids_of(World(name="w", walls=(wall,))) if s.glass is not None]
    assert len(panes) == 1 and panes[0].size[0] == pytest.approx(1.0)


def test_a_glass_box_has_four_panes_round_nothing() -> None:
    box = Furniture(name="case", center_m=(1, 1), size_m=(1.0, 0.6, 1.2), glass=Glass())
    panes = solids_of(World(name="w", boxes=(box,)))
    assert len(panes) == 4
    assert all(pane.signed_distance(np.array([[1.0, 1.0]]))[0] > 0.2 for pane in panes)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"walls": [{"from_m": [0, 0], "to_m": [1, 0], "frame": {}}]}, "needs glass"),
        ({"tables": [{"name": "t", "center_m": [0, 0], "size_m": [1, 1, 1], "glass": {}}]}, "'t'"),
        ({"walls": [{"from_m": [0, 0], "to_m": [1, 0], "glass": {"colour": 1}}]}, "'colour'"),
        ({"measures": [{"name": "a", "from_m": [0, 0], "to_m": [0, 0]}]}, "coincide"),
    ],
)
def test_glass_that_cannot_be_is_refused(data: dict, words: str) -> None:
    with pytest.raises(WorldError, match=words):
        build(World, {"name": "w", **data}, "w.yaml")


def test_the_papers_lengths_are_in_its_worlds() -> None:
    def values(name: str) -> dict[str, float]:
        return {m.name: m.value for m in load_world(name).measures}

    assert values("glass_corridor") == pytest.approx({"a": 2.54, "b": 90.0, "c": 0.62, "d": 0.53})
    assert values("glass_wall") == pytest.approx({"a": 2.51, "b": 90.0, "c": 3.63})


def test_measures_lie_on_surfaces() -> None:
    for name in ("glass_corridor", "glass_wall"):
        world = load_world(name)
        solids = solids_of(world)
        for m in world.measures:
            for point in (m.from_m, m.to_m, *([m.corner_m] if m.corner_m else [])):
                off = min(float(abs(s.signed_distance(np.array([point]))[0])) for s in solids)
                assert off < 0.031, f"{name}: {m.name} at {point} is {off:.3f} m off"


def test_an_angle_is_measured_at_its_corner() -> None:
    m = Measure(name="b", from_m=(1.0, 0.0), corner_m=(0.0, 0.0), to_m=(0.0, 2.0))
    assert (m.value, m.unit) == (pytest.approx(90.0), "deg")


@pytest.mark.parametrize("name", ROUTES)
def test_routes_keep_clear_of_everything(name: str) -> None:
    world = load_world(name)
    points = np.array([world.robots[0].position_m, *world.route.waypoints_m])
    way = np.vstack([np.linspace(a, b, 40) for a, b in zip(points, points[1:], strict=False)])
    for solid in solids_of(world):
        clear = solid.signed_distance(way).min()
        assert solid.bottom > 0.41 or clear > HALF_WIDTH_M, f"{solid.name}: {clear:.2f} m"


def test_a_robot_touches_glass_as_it_does_a_wall(simulate) -> None:
    from sim_bridge.drive import Velocity

    simulation = simulate(_room_with_glass_at_4())
    seen = [simulation.step({"": Velocity(0.8, 0.0)}) for _ in range(600)][-1].robots[""]
    assert seen.ground_truth.is_touching
    assert seen.ground_truth.pose.x == pytest.approx(4.0 - 0.20, abs=0.03)


def test_more_sonars_change_no_other_sensors_noise() -> None:
    def scan(overrides: dict) -> np.ndarray:
        robot = RobotPlacement(model="segway_rmp50", position_m=(2, 1), overrides=overrides)
        return snapshot(replace(box_room(), robots=(robot,)), SE2(2, 1, 0), 5).scan.ranges

    fewer = {"count": 4, "groups": []}
    assert np.array_equal(scan({}), scan({"sonar": fewer}), equal_nan=True)
