"""Generated floors: repeatable, with the share of glass asked for, free to drive."""

import numpy as np
import pytest

from sim_bridge.generator import OUTER_WALLS, generate_floor
from sim_bridge.schema import WorldError
from sim_bridge.solids import solids_of
from sim_bridge.world import load_world

HALF_WIDTH_M = 0.28
SEEDS = range(12)


def _glass_share(world) -> float:
    inner = world.walls[OUTER_WALLS:]
    return sum(w.length for w in inner if w.glass) / sum(w.length for w in inner)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 1.0])
def test_the_share_of_inner_walls_in_glass_is_the_one_asked_for(share: float) -> None:
    for seed in SEEDS:
        assert _glass_share(generate_floor(seed, share)) == pytest.approx(share, abs=0.005)


def test_the_same_seed_gives_the_same_floor_and_another_one_another() -> None:
    assert generate_floor(3, 0.3) == generate_floor(3, 0.3)
    assert generate_floor(3, 0.3) != generate_floor(4, 0.3)


def test_the_share_of_glass_moves_neither_walls_nor_furniture() -> None:
    clear, dark = generate_floor(5, 0.8), generate_floor(5, 0.0)
    assert (clear.tables, clear.boxes, clear.shelves) == (dark.tables, dark.boxes, dark.shelves)
    ends = [sum(wall.length for wall in world.walls) for world in (clear, dark)]
    assert ends[0] == pytest.approx(ends[1])


def test_routes_keep_clear_of_everything() -> None:
    for seed in range(30):
        world = generate_floor(seed, 0.4)
        points = np.array([world.robots[0].position_m, *world.route.waypoints_m])
        way = np.vstack([np.linspace(a, b, 30) for a, b in zip(points, points[1:], strict=False)])
        for solid in solids_of(world):
            clear = solid.signed_distance(way).min()
            assert clear > HALF_WIDTH_M, f"seed {seed}: {solid.name} is {clear:.2f} m off the route"


def test_floors_differ_in_size_and_number_of_rooms() -> None:
    floors = [generate_floor(seed, 0.2) for seed in SEEDS]
    assert len({floor.description for floor in floors}) > 3


def test_a_floor_has_a_name_of_its_own() -> None:
    world = load_world("generated:7:0.3")
    assert world == generate_floor(7, 0.3) and world.name == "generated-7-0.3"


@pytest.mark.parametrize("name", ["generated:1", "generated:x:0.2", "generated:1:2", "generated:"])
def test_a_name_that_cannot_be_is_refused(name: str) -> None:
    with pytest.raises(WorldError, match="generated|glass share"):
        load_world(name)
