"""Solids for the renderer without an engine."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.solids import Solid, solids_of
from sim_bridge.still_shapes import StillShapes, solid_pose
from sim_bridge.world import load_world

BOX = Solid("crate", SE2(1.0, 2.0, math.pi / 2.0), (0.4, 0.6, 0.8), 0.1, False, (1.0, 0.5, 0.0))


def test_a_solid_stands_at_the_middle_of_its_height() -> None:
    np.testing.assert_allclose(solid_pose(BOX)[:3, 3], (1.0, 2.0, 0.5))
    np.testing.assert_allclose(solid_pose(BOX)[:2, :2], ((0.0, -1.0), (1.0, 0.0)), atol=1e-12)


def test_one_that_is_put_elsewhere_stands_on_the_floor_in_its_color() -> None:
    shapes = StillShapes([BOX, BOX])
    shapes.put(1, SE2(-3.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    np.testing.assert_allclose(shapes.poses()[:, :3, 3], ((1.0, 2.0, 0.5), (-3.0, 0.0, 0.4)))
    np.testing.assert_allclose(shapes.colors, ((1.0, 0.5, 0.0), (0.0, 0.0, 1.0)))


def test_balls_and_glass_are_refused() -> None:
    with pytest.raises(ValueError, match="got a ball or a pane"):
        StillShapes(solids_of(load_world("small_size_field")))
    with pytest.raises(ValueError, match="got a ball or a pane"):
        StillShapes(solids_of(load_world("glass_wall")))
