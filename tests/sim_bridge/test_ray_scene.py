"""Rays of our own against the engine's: the same hits and normals, for all that worlds hold."""

import numpy as np
import pytest

from sim_bridge.drive import Velocity
from sim_bridge.physics import Physics
from sim_bridge.rays import Hits
from sim_bridge.simulation import Simulation
from sim_bridge.world import load_world

from .conftest import PERFECT, box_room

TOL = 2e-4  # of a ray's length; the engine's own margin
_SAME = 0.995  # edges fall on one side or the other


def _engine_hits(physics: Physics, starts: np.ndarray, ends: np.ndarray) -> Hits:
    """Return what the engine's own rays meet; it does not say what things are made of."""
    answers = physics._engine.rayTestBatch(
        starts.tolist(), ends.tolist(), collisionFilterMask=-1, physicsClientId=physics._client
    )
    shares = np.array([hit[2] if hit[0] >= 0 else np.inf for hit in answers])
    return Hits(shares, np.array([hit[4] for hit in answers]), np.zeros(len(answers), int))


def _both(simulation: Simulation, num: int, seed: int = 0) -> tuple:
    physics, rng = simulation._physics, np.random.default_rng(seed)
    starts = np.column_stack((rng.uniform(0.5, 5.5, (num, 2)), rng.uniform(0.05, 1.5, num)))
    ends = starts + rng.normal(0.0, 4.0, (num, 3)) * [1.0, 1.0, 0.1]
    ours = physics._rays.cast(starts, ends)
    theirs = _engine_hits(physics, starts, ends)
    return ours, theirs


@pytest.mark.parametrize("world", ["furnished_floor", "crowd"])
def test_rays_end_where_the_engine_says(simulate, world: str) -> None:
    simulation = simulate(load_world(world), seed=1)
    for _ in range(30):
        simulation.step(dict.fromkeys(simulation.models, Velocity(0.5, 0.3)))
    ours, theirs = _both(simulation, 4000)
    hit = np.isfinite(ours.shares)
    assert np.mean(hit == np.isfinite(theirs.shares)) > _SAME
    both = hit & np.isfinite(theirs.shares)
    is_same = np.abs(ours.shares[both] - theirs.shares[both]) < TOL + 0.002
    assert is_same.mean() > _SAME
    turned = (ours.normals[both] * theirs.normals[both]).sum(axis=1)[is_same]
    assert np.mean(turned > 0.99) > 0.98


def test_a_ray_onto_a_wall_by_hand(simulate) -> None:
    simulation = simulate(box_room(PERFECT))
    hits = simulation._physics._rays.cast(np.array([[3.0, 2.0, 1.0]]), np.array([[3.0, 6.0, 1.0]]))
    assert hits.shares[0] == pytest.approx(0.5) and np.allclose(hits.normals[0], [0, -1, 0])


def test_an_unseen_group_is_not_hit(simulate) -> None:
    simulation = simulate(box_room(PERFECT))
    start, end = np.array([[2.0, 3.0, 0.2]]), np.array([[2.0, -1.0, 0.2]])
    rays = simulation._physics._rays
    with_robot, without = (rays.cast(start, end, unseen).shares[0] for unseen in ((), (3,)))
    assert with_robot == pytest.approx((3.0 - 1.28) / 4.0)
    assert without == pytest.approx(3.0 / 4.0)
