"""Solids: doors, legs, distances by hand."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.solids import distance_to_surface, moved, solids_of
from sim_bridge.world import Column, Door, Furniture, Wall, World

WALL = Wall(
    from_m=(0.0, 0.0), to_m=(4.0, 0.0), thickness_m=0.2, doors=(Door(at_m=2.0, width_m=1.0),)
)


def test_a_door_leaves_a_gap() -> None:
    pieces = solids_of(World(name="w", walls=(WALL,)))
    assert [p.pose.x for p in pieces] == pytest.approx([0.7, 3.3])
    assert [p.size[0] for p in pieces] == pytest.approx([1.6, 1.6])


def test_a_table_shows_four_legs_below_its_top() -> None:
    table = Furniture(name="t", center_m=(0.0, 0.0), size_m=(1.0, 0.6, 0.7))
    solids = solids_of(World(name="w", tables=(table,)))
    assert sum(s.is_at_height(0.3) for s in solids) == 4
    assert sum(s.is_at_height(0.69) for s in solids) == 1


def test_distances_to_a_box_and_a_column() -> None:
    box = Furniture(name="b", center_m=(0.0, 0.0), size_m=(2.0, 1.0, 1.0))
    column = Column(name="c", center_m=(5.0, 0.0), radius_m=0.5)
    solids = solids_of(World(name="w", boxes=(box,), columns=(column,)))
    points = np.array([[2.0, 0.0], [0.0, 0.3], [2.0, 1.5], [5.0, 0.0], [4.0, 0.0]])
    expected = [1.0, 0.2, np.sqrt(2.0), 0.5, 0.5]
    assert distance_to_surface(solids, points) == pytest.approx(expected)


def test_distances_move_with_the_world() -> None:
    solids = solids_of(World(name="w", walls=(WALL,)))
    points = np.random.default_rng(0).uniform(-1.0, 5.0, (50, 2))
    T = SE2(3.0, -2.0, 0.7)
    assert distance_to_surface(moved(solids, T), T @ points) == pytest.approx(
        distance_to_surface(solids, points)
    )


def test_a_world_without_solids_is_infinitely_far() -> None:
    assert np.isinf(distance_to_surface([], np.zeros((2, 2)))).all()
