"""scripts/_demo_surface.py: what a laser could see, and how much of it is in a map."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("sim_bridge.solids")

from _demo_surface import share_found, visible_surface
from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.solids import Solid

ALL_ROUND = np.radians(np.arange(-180.0, 180.0, 0.2))
REACH_M = 10.0


def box(x: float, y: float, size: tuple[float, float], glass: Glass | None = None) -> Solid:
    return Solid("box", SE2(x, y, 0.0), (*size, 1.0), 0.0, False, (0.5, 0.5, 0.5), glass=glass)


def test_only_the_near_face_of_a_box_is_seen_from_straight_before_it():
    points = visible_surface([box(2.5, 0.0, (1.0, 2.0))], [SE2(0.0, 0.0, 0.0)], ALL_ROUND, REACH_M)
    assert points[:, 0] == pytest.approx(2.0)
    # Every patch of the 2 m face gets at least three of the 0.2 degree beams but some at the ends.
    assert np.ptp(points[:, 1]) < 2.0 + 1e-9 and len(points) <= 42


def test_a_wall_hides_what_is_behind_it_and_glass_does_not():
    far = box(3.5, 0.0, (1.0, 1.0))
    for glass, is_seen in ((None, False), (Glass(), True)):
        near = box(1.0, 0.0, (0.02, 4.0), glass)
        points = visible_surface([near, far], [SE2(0.0, 0.0, 0.0)], ALL_ROUND, REACH_M)
        assert bool((points[:, 0] > 2.9).any()) == is_seen
        assert bool((points[:, 0] < 1.1).any()) != is_seen


def test_what_is_beyond_the_longest_range_is_not_seen():
    solids = [box(5.0, 0.0, (1.0, 1.0))]
    assert len(visible_surface(solids, [SE2(0.0, 0.0, 0.0)], ALL_ROUND, 4.0)) == 0


def test_world_and_laser_moved_together_give_the_same_distances():
    solids, T = [box(2.5, 0.3, (1.0, 2.0))], SE2(3.0, -1.0, 0.7)
    moved = [Solid("box", T @ solids[0].pose, *vars_of(solids[0]))]
    before = visible_surface(solids, [SE2(0.0, 0.0, 0.0)], ALL_ROUND, REACH_M)
    after = visible_surface(moved, [T], ALL_ROUND, REACH_M)
    # Patches lie elsewhere, so points differ; the face that they are on does not.
    assert (T.inverse() @ after)[:, 0] == pytest.approx(2.0)
    assert np.ptp((T.inverse() @ after)[:, 1]) == pytest.approx(np.ptp(before[:, 1]), abs=0.15)


def vars_of(solid: Solid) -> tuple[object, ...]:
    return (solid.size, solid.bottom, solid.is_round, solid.color)


def test_the_share_counts_surface_points_with_a_cell_within_ten_centimetres():
    surface = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    occupied = np.array([[0.0, 0.05], [1.0, 0.09], [2.0, 0.11]])
    assert share_found(surface, occupied) == 0.5
    assert share_found(surface, np.zeros((0, 2))) == 0.0
    assert share_found(np.zeros((0, 2)), occupied) is None
