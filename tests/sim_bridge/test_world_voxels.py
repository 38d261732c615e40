"""A world as voxels: what is occupied by hand, and colors as the renderer has them."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.appearance import Floor
from sim_bridge.cameras import pinhole_rays
from sim_bridge.glass import Glass
from sim_bridge.scene import CEILING_COLOR, Scene
from sim_bridge.solids import Solid, solids_of
from sim_bridge.still_shapes import StillShapes
from sim_bridge.surface_samples import solid_samples
from sim_bridge.views import looking
from sim_bridge.world import Ball, Column, Furniture, Wall, World
from sim_bridge.world_voxels import WorldVoxels, world_voxels

FLOOR = Floor(color=(0.2, 0.4, 0.6), to_m=(1.0, 0.5), carpet=0.0)


def at(made: WorldVoxels, x: float, y: float, z: float) -> tuple[bool, list[int]]:
    """Return whether the voxel at a point is occupied, and its color."""
    column, row, layer = np.floor((np.array([x, y, z]) - made.origin) / (0.01, 0.01, 0.2)).astype(
        int
    )
    return bool(made.occupied[layer, row, column]), made.color[layer, row, column].tolist()


def test_a_box_by_hand():
    box = Furniture(name="box", center_m=(0.5, 0.2), size_m=(0.2, 0.1, 0.5), color=(1.0, 0.0, 0.0))
    made = world_voxels(World(name="w", floor=FLOOR, boxes=(box,), ceiling_m=1.0), 0.01, 0.2)
    assert made.occupied.shape == (1 + 5 + 1, 52, 102)
    assert made.origin == pytest.approx((-0.01, -0.01, -0.2))
    assert at(made, 0.405, 0.155, 0.1) == (True, [255, 0, 0])
    assert at(made, 0.395, 0.2, 0.1)[0] is False and at(made, 0.605, 0.2, 0.1)[0] is False
    assert at(made, 0.5, 0.2, 0.5)[0] is True  # of 0.4 to 0.6 m it takes half
    assert at(made, 0.5, 0.2, 0.7)[0] is False
    assert at(made, 0.9, 0.4, -0.1) == (True, [51, 102, 153])
    assert at(made, 0.9, 0.4, 1.1) == (True, [round(255 * c) for c in CEILING_COLOR])
    assert at(made, 0.9, 0.4, 0.9) == (False, [0, 0, 0])


def test_thin_boards_panes_and_balls_are_left_out():
    table = Furniture(name="table", center_m=(0.5, 0.25), size_m=(0.6, 0.3, 0.5))
    ball = Ball(name="ball", center_m=(0.1, 0.1), radius_m=0.05)
    pane = Wall(from_m=(0.0, 0.45), to_m=(1.0, 0.45), glass=Glass())
    world = World(name="w", floor=FLOOR, tables=(table,), balls=(ball,), walls=(pane,))
    made = world_voxels(world, 0.01, 0.2)
    assert set(made.left_out) == {"ball", "glass"}
    assert at(made, 0.5, 0.25, 0.49)[0] is False and at(made, 0.225, 0.125, 0.1)[0] is True


def test_a_column_is_round():
    post = Column(name="post", center_m=(0.5, 0.25), radius_m=0.1, height_m=0.4)
    made = world_voxels(World(name="w", floor=FLOOR, columns=(post,)), 0.01, 0.2)
    area = made.occupied[1].sum() * 1e-4
    assert area == pytest.approx(np.pi * 0.01, rel=0.03)


def test_a_world_without_a_floors_picture_reaches_over_its_solids():
    wall = Wall(from_m=(1.0, 2.0), to_m=(3.0, 2.0), height_m=0.4)
    made = world_voxels(World(name="w", walls=(wall,)), 0.01, 0.2)
    assert made.origin == pytest.approx((1.0 - 0.06 - 0.01, 2.0 - 0.06 - 0.01, -0.2))
    with pytest.raises(ValueError, match="neither"):
        world_voxels(World(name="w"), 0.01, 0.2)


@pytest.mark.parametrize("turn", [0.0, 2.0])
@pytest.mark.parametrize("texture", ["books", "paper"])
def test_colors_are_those_that_a_camera_sees(texture, turn):
    """A camera close to one side of a turned box: each sample's color is where it is drawn."""
    wall = Solid("w", SE2(1.0, 0.5, turn), (0.6, 0.3, 0.5), 0.0, False, (0.5, 0.4, 0.3))
    wall = Solid(**{**wall.__dict__, "texture": texture})
    samples = solid_samples(wall, 0.004, 0.0)
    out = np.array([np.sin(turn), -np.cos(turn)])  # normal of the side at -y of the box
    front = np.array([1.0, 0.5]) + 0.15 * out
    eye, target = (*(front + 0.5 * out), 0.25), (*front, 0.25)
    T = looking(eye, target, (0.0, 0.0, 1.0))
    rays = pinhole_rays(200, 160, 180.0, samples=1)
    world = World(name="w", floor=FLOOR)
    light = Scene(world, StillShapes([wall]), np.eye(4)).light_at(rays, T)
    seen = (samples.points - eye) @ T[:3, :3]
    on = np.abs(seen[:, 2] - 0.5) < 1e-6
    u, v = np.rint(seen[on][:, :2] / 0.5 * 180.0 + (99.5, 79.5)).astype(int).T
    near = (abs(u - 99.5) < 80) & (abs(v - 79.5) < 60)
    drawn = light[v[near], u[near]]
    both = np.stack((drawn, samples.colors[on][near])) + 0.05  # black has no shares
    shares = both / both.sum(axis=2, keepdims=True)
    assert near.sum() > 1000
    assert np.median(np.abs(shares[0] - shares[1])) < 0.01
    assert np.corrcoef(shares[0][:, 0], shares[1][:, 0])[0, 1] > 0.9


def test_solids_of_the_stereo_room_fill_the_papers_grid():
    from sim_bridge.world import load_world

    world = load_world("stereo_room")
    made = world_voxels(world, 0.04, 0.32)
    assert made.occupied.shape == (8 + 2, 128 + 2, 128 + 2) and made.left_out == ()
    assert not made.occupied[2:5, 40:90, 40:90].any() and len(solids_of(world)) == 14
