"""Maps from posed views: a wall by hand, errors that average out, and a map seen from inside."""

from __future__ import annotations

import numpy as np
import pytest

from multi_localizer.voxel_fusion import FusionSettings, PosedView, extent_of, fuse_views

SHAPE, FOCAL = (60, 80), 60.0
FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # z of the camera along x
CENTER = (39.5, 29.5)
SETTINGS = FusionSettings(cell_m=0.01, layer_m=0.1)


def view(depth: np.ndarray, x: float = 0.0, color: int = 90) -> PosedView:
    """Return what a camera at (x, 0, 0.5) sees that looks along +x."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = FORWARD, (x, 0.0, 0.5)
    image = np.full((*SHAPE, 3), (color, 50, 20), dtype=np.uint8)
    return PosedView(T, image, depth, (FOCAL, FOCAL), CENTER)


def wall(distance: float, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    return distance + noise * np.random.default_rng(seed).standard_normal(SHAPE)


def column_of(voxels, y: float, z: float) -> np.ndarray:
    """Return the x of the occupied voxels' near sides at a y and z."""
    row = int((y - voxels.origin_y_m) / voxels.cell_m)
    layer = int((z - voxels.origin_z_m) / voxels.layer_m)
    columns = np.flatnonzero(voxels.occupied[layer, row])
    return np.asarray(voxels.origin_x_m + columns * voxels.cell_m)


def test_a_wall_stands_where_it_is_seen():
    low, high = np.array([0.0, -0.3, 0.3]), np.array([1.2, 0.3, 0.7])
    voxels = fuse_views([view(wall(1.0))], low, high, SETTINGS)
    found = column_of(voxels, 0.0, 0.55)
    assert found[0] == pytest.approx(1.0, abs=0.011) and found[-1] <= 1.08
    assert voxels.color[voxels.occupied].tolist()[0] == [90, 50, 20]


def test_a_wall_found_a_little_beyond_the_bounds_has_no_holes():
    low, high = np.array([0.5, -0.2, 0.4]), np.array([1.0, 0.2, 0.6])
    voxels = fuse_views([view(wall(1.0 + 0.04))], low, high, SETTINGS)
    assert all(len(column_of(voxels, y, 0.5)) for y in np.arange(-0.15, 0.15, 0.02))


def test_errors_of_many_views_average_out():
    low, high = np.array([0.5, -0.2, 0.4]), np.array([1.2, 0.2, 0.6])
    views = [view(wall(1.0, 0.02, k)) for k in range(40)]
    voxels = fuse_views(views, low, high, SETTINGS)
    starts = [column_of(voxels, y, 0.55)[0] for y in np.arange(-0.15, 0.15, 0.02)]
    assert np.abs(np.array(starts) - 1.0).max() < 0.025


def test_what_is_seen_through_is_free():
    low, high = np.array([0.5, -0.2, 0.4]), np.array([1.2, 0.2, 0.6])
    ghost = wall(1.0)
    ghost[20:40, 30:50] = 0.7
    views = [view(ghost)] + [view(wall(1.0)) for _ in range(2)]
    assert column_of(fuse_views(views, low, high, SETTINGS), 0.0, 0.55)[0] > 0.95


def test_far_views_weigh_less_where_errors_grow():
    low, high = np.array([0.5, -0.2, 0.4]), np.array([2.2, 0.2, 0.6])
    views = [view(wall(2.04)), view(wall(1.0), x=1.0)]  # the far one is wrong by 4 cm
    for grows, at_most in ((True, 2.015), (False, 2.035)):
        settings = FusionSettings(layer_m=0.1, error_grows=grows)
        start = column_of(fuse_views(views, low, high, settings), 0.0, 0.55)[0]
        assert start <= at_most and (grows or start > 2.005)


def test_nothing_known_is_nothing_occupied_and_bad_input_is_named():
    nothing = view(np.full(SHAPE, np.nan))
    low, high = np.zeros(3), np.ones(3)
    assert not fuse_views([nothing], low, high, SETTINGS).occupied.any()
    with pytest.raises(ValueError, match="no distance"):
        extent_of([nothing], 4.0)
    with pytest.raises(ValueError, match="at least one"):
        fuse_views([], low, high, SETTINGS)
    with pytest.raises(ValueError, match="below high"):
        fuse_views([nothing], high, -high, SETTINGS)
    with pytest.raises(ValueError, match="uint8"):
        PosedView(np.eye(4), np.zeros((*SHAPE, 3)), wall(1.0), (1.0, 1.0), CENTER)
    with pytest.raises(ValueError, match="cell_m"):
        FusionSettings(cell_m=0.0)


def test_the_extent_is_what_is_seen():
    low, high = extent_of([view(wall(1.0))], 4.0)
    assert low == pytest.approx((1.0, -39.5 / 60.0, 0.5 - 29.5 / 60.0), abs=0.07)
    assert high == pytest.approx((1.0, 39.5 / 60.0, 0.5 + 29.5 / 60.0), abs=0.07)
