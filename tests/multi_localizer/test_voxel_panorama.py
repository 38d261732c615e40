import numpy as np
import pytest
from voxel_rooms import CAMERAS, FRONT, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_search_all import SearchAll
from multi_localizer.voxel_panorama import (
    BLANK,
    PanoramaShape,
    highest_slope,
    make_panoramas,
    window_columns,
    window_of,
)
from multi_localizer.voxel_view import VoxelScene

SHAPE = PanoramaShape(64, 4, highest_slope(FRONT))


@pytest.fixture(scope="module")
def scene():
    return VoxelScene(room())


@pytest.fixture(scope="module")
def panoramas(scene):
    return make_panoramas(scene, 1.0, 0.4, SHAPE, window_columns(FRONT, SHAPE))


def test_places_cover_the_map_evenly(panoramas):
    assert panoramas.xs == pytest.approx(0.2 + 0.4 * np.arange(8))
    assert panoramas.ys == pytest.approx(0.2 + 0.4 * np.arange(6))
    assert panoramas.spacing == pytest.approx((0.4, 0.4))


def test_a_panorama_sees_the_walls_where_they_are(panoramas):
    cells = panoramas.cells[3, 5]  # x 2.2 m, y 1.4 m; the far wall's inner face is at 3.18 m
    assert cells[1:3, 2, 0] == pytest.approx(1.0 / 0.98, rel=0.01)
    assert cells[1:3, 2, 16] == pytest.approx(1.0 / 0.98, rel=0.01)  # y: 2.38 - 1.4


def test_columns_are_repeated_behind_the_last_one(panoramas):
    more = panoramas.cells.shape[4] - SHAPE.columns
    assert more == window_columns(FRONT, SHAPE) > 0
    cells = panoramas.cells
    assert np.array_equal(cells[..., SHAPE.columns :], cells[..., :more])


def test_places_in_things_are_blank(scene):
    panoramas = make_panoramas(scene, 0.5, 0.1, SHAPE, 0)
    assert not panoramas.is_free.all()
    assert (panoramas.cells[~panoramas.is_free] == BLANK).all()


@pytest.mark.parametrize("heading", [0, 10, 37])
def test_a_view_is_a_window_of_the_panorama(scene, panoramas, heading):
    x, y = panoramas.xs[5], panoramas.ys[3]
    yaw = heading * SHAPE.step
    base = SE2(x, y, yaw) @ SE2(-FRONT.x_m, -FRONT.y_m, 0.0)  # the camera stands at (x, y)
    view = views_at(scene.voxels, base, (FRONT,))[0]
    cells, weights = window_of(view, FRONT, SHAPE)
    num = cells.shape[2]
    first = (heading - num // 2) % SHAPE.columns
    window = panoramas.cells[3, 5][:, :, first : first + num]
    seen = weights.min(axis=1) > 0.9
    assert seen.mean() > 0.4
    assert np.median(np.abs(cells[:, 2] - window[:, 2])[seen]) < 0.02
    assert np.median(np.abs(cells[:, 0] - window[:, 0])[seen]) < 0.04


@pytest.mark.parametrize("pose", [SE2(1.6, 1.2, 0.4), SE2(2.3, 1.6, -2.2)])
def test_the_best_candidate_is_within_its_mesh(scene, pose):
    config = StereoLocalizerConfig(panorama_columns=64)
    poses = SearchAll(scene, CAMERAS, config).search(views_at(scene.voxels, pose), 5)
    assert poses.shape == (5, 3)
    assert np.hypot(*(poses[0, :2] - [pose.x, pose.y])) < 0.1
    assert abs(SE2(0.0, 0.0, poses[0, 2] - pose.yaw).yaw) < 2.0 * np.pi / 64


def test_a_large_map_has_no_more_places_than_allowed(scene):
    few = StereoLocalizerConfig(panorama_columns=16, max_places=30)
    search = SearchAll(scene, CAMERAS, few)
    pose = SE2(1.6, 1.2, 0.4)
    assert len(search.search(views_at(scene.voxels, pose), 1000)) <= 42 * 16
