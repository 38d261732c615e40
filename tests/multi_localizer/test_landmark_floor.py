"""Method 2: where the floor ends in a direction, and poses from points seen."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.camera_files import load_camera_model
from floornav_common.se2 import SE2
from multi_localizer.landmark_floor import FloorEnds, floor_fix
from multi_localizer.pose_estimate import difference

CAMERA = load_camera_model("soccer_middle_size")
PIXELS = np.stack(np.meshgrid(np.arange(160.0), np.arange(120.0)), axis=-1)
FLOOR = CAMERA.floor_points(PIXELS)


def mask_of(is_floor: np.ndarray) -> np.ndarray:
    return np.where(is_floor & np.isfinite(FLOOR).all(axis=-1), 255, 0).astype(np.uint8)


def wall_at(x: float) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return FLOOR[..., 0] < x


@pytest.mark.parametrize("distance", [0.6, 1.0, 1.7, 2.5])
@pytest.mark.parametrize("bearing", [0.0, 0.4, -0.7])
def test_the_floor_ends_at_the_wall_to_half_a_pixel(distance: float, bearing: float) -> None:
    end = FloorEnds(CAMERA).end(mask_of(wall_at(distance)), bearing)
    assert end is not None
    true = distance / math.cos(bearing)
    assert abs(end.distance - true) < 0.8 * end.meters_per_px


def test_something_that_stands_before_the_foot_does_not_matter() -> None:
    wall = wall_at(1.7)
    with np.errstate(invalid="ignore"):
        ball = np.hypot(FLOOR[..., 0] - 0.9, FLOOR[..., 1]) < 0.1
    with_ball = FloorEnds(CAMERA).end(mask_of(wall & ~ball), 0.0)
    assert with_ball == FloorEnds(CAMERA).end(mask_of(wall), 0.0)


def test_no_floor_in_a_direction_is_no_distance() -> None:
    assert FloorEnds(CAMERA).end(mask_of(wall_at(-0.3)), 0.0) is None
    assert FloorEnds(CAMERA).end(np.zeros((120, 160), dtype=np.uint8), 1.0) is None


def test_floor_up_to_the_end_of_sight_is_no_distance() -> None:
    assert FloorEnds(CAMERA).end(np.full((120, 160), 255, dtype=np.uint8), 1.0) is None


def test_a_mask_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="160 x 120"):
        FloorEnds(CAMERA).end(np.zeros((10, 10), dtype=np.uint8), 0.0)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1))
def test_points_laid_over_the_map_give_the_pose(x: float, y: float, yaw: float) -> None:
    pose = SE2(x, y, yaw)
    points = np.array([[4.0, 0.0], [-4.0, 1.0], [0.5, 3.0]])
    for num in (2, 3):
        seen = pose.inverse() @ points[:num]
        assert difference(floor_fix(points[:num], seen), pose) == pytest.approx(0.0, abs=1e-9)


def test_one_point_or_twice_the_same_gives_no_pose() -> None:
    assert floor_fix(np.zeros((1, 2)), np.zeros((1, 2))) is None
    assert floor_fix(np.zeros((2, 2)), np.ones((2, 2))) is None
