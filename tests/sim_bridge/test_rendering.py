"""Few rays against many: what casting one ray a pixel where light is even may change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from camera_worlds import CLEAN, ring_world

from sim_bridge.drive import Velocity
from sim_bridge.world import Column, World, load_world

ALL_RAYS = {"refine_above": -1.0}
ONE_RAY = {"samples": 1}
TOL_MEAN = 0.3  # 8-bit levels
TOL_EVEN = 5.0  # where neighbors are alike
TOL_SHARE = 0.002  # of values farther off: things thinner than a pixel


def _field(omni: dict) -> World:
    world = load_world("small_size_field")
    robot = replace(world.robots[0], overrides={"omni": {"image": CLEAN, **omni}})
    return replace(world, robots=(robot,))


def _image(simulate, world: World) -> np.ndarray:
    simulation = simulate(world)
    seen = [simulation.step({"": Velocity(0.0, 0.0)}).robots[""] for _ in range(10)]
    return next(s.omni for s in seen if s.omni is not None).astype(int)


@pytest.mark.parametrize("size", [(256, 220), (640, 480)])
def test_an_image_of_the_field_is_that_of_all_rays_within_a_known_tolerance(simulate, size) -> None:
    omni = {"width_px": size[0], "height_px": size[1]}
    few = _image(simulate, _field(omni))
    all_rays = _image(simulate, _field({**omni, **ALL_RAYS}))
    one = _image(simulate, _field({**omni, **ONE_RAY}))
    difference = np.abs(few - all_rays)[all_rays.max(axis=2) > 0]
    assert 0.0 < difference.mean() < TOL_MEAN
    assert (difference > TOL_EVEN).mean() < TOL_SHARE
    # One ray everywhere is far worse, so the tolerance is one that can be missed.
    assert (np.abs(one - all_rays)[all_rays.max(axis=2) > 0] > TOL_EVEN).mean() > 10.0 * TOL_SHARE


def test_straight_edges_between_even_colors_get_every_ray(simulate) -> None:
    # If one ray of a pixel's square falls beyond a straight edge, so does the middle of a neighbor.
    worlds = [ring_world((0.3, 0.5, 0.9), {"samples": 2, **omni}) for omni in ({}, ALL_RAYS)]
    few, all_rays = (_image(simulate, world) for world in worlds)
    step = 0.85 * 255.0
    assert np.abs(few - all_rays).max() <= 0.03 * 255.0
    is_edge = (all_rays.max(axis=2) > 0.05 * step) & (all_rays.max(axis=2) < 0.9 * step)
    assert is_edge.sum() > 500


def test_without_tolerance_every_uneven_pixel_gets_every_ray(simulate) -> None:
    post = Column(name="post", center_m=(0.4, 0.3), radius_m=0.05, height_m=0.15)
    images = [
        _image(simulate, replace(ring_world((0.5,), {"samples": 2, **omni}), columns=(post,)))
        for omni in ({"refine_above": 0.0}, ALL_RAYS)
    ]
    assert np.abs(images[0] - images[1]).max() <= 1
