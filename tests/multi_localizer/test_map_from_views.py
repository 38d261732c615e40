"""A map made from noisy posed views, used to find the pose: right, or said not to be known."""

from __future__ import annotations

import numpy as np
import pytest
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState
from multi_localizer.voxel_fusion import FusionSettings, PosedView, fuse_views
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import VoxelScene

FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
CONFIG = StereoLocalizerConfig(panorama_spacing_m=0.12, max_places=500, num_refined=12)
PLACES = [SE2(1.6, 1.0, 0.4), SE2(2.4, 1.6, -2.0), SE2(1.1, 1.7, 2.5)]
NUM_VIEWS, NOISE_PX, TOL_M = 120, 0.5, 0.04


def map_of_views(voxels: VoxelMap, seed: int = 0) -> VoxelMap:
    """Return the map that pairs make which see a room from random places, with noise."""
    rng, scene = np.random.default_rng(seed), VoxelScene(voxels)
    width, depth, height = voxels.size_m
    views: list[PosedView] = []
    while len(views) < NUM_VIEWS:
        pose = SE2(*rng.uniform((0.3, 0.3, -np.pi), (width - 0.3, depth - 0.3, np.pi)).tolist())
        camera = CAMERAS[len(views) % 2]
        if not scene.is_free(pose.as_array()[None], camera)[0]:
            continue
        size = camera.width_px, camera.height_px
        color, distance = scene.render(pose.as_array()[None], camera, size)
        disparity = camera.pixel_meters / distance[0]
        disparity += NOISE_PX * rng.standard_normal(disparity.shape)
        T_map_camera = np.eye(4)
        at = pose @ SE2(camera.x_m, camera.y_m, camera.yaw)
        c, s = np.cos(at.yaw), np.sin(at.yaw)
        T_map_camera[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ FORWARD
        T_map_camera[:3, 3] = at.x, at.y, camera.height_m
        found = camera.pixel_meters / np.maximum(disparity, 0.1)
        focal, image = (camera.focal_px, camera.focal_px), np.rint(color[0]).astype(np.uint8)
        views.append(PosedView(T_map_camera, image, found, focal, camera.center_px))
    settings = FusionSettings(cell_m=voxels.cell_m, layer_m=voxels.layer_m, error_grows=True)
    low, high = np.zeros(3), np.array([width, depth, height - 2.0 * voxels.layer_m])
    return fuse_views(views, low, high, settings)


@pytest.fixture(scope="module", params=[False, True], ids=["room", "twofold"])
def case(request):
    voxels = room(is_twofold=request.param)
    return voxels, StereoLocalizer(map_of_views(voxels), CAMERAS, CONFIG), request.param


@pytest.mark.parametrize("place", PLACES, ids=["a", "b", "c"])
def test_the_pose_is_right_or_not_said_to_be_known(case, place):
    voxels, localizer, is_twofold = case
    found = localizer.locate(views_at(voxels, place, noise_px=0.3))
    off = [np.hypot(*difference(h.estimate.pose, place)[:2]) for h in found.hypotheses]
    assert min(off) < TOL_M
    if is_twofold:
        assert found.state is StereoState.AMBIGUOUS or off[0] < TOL_M
    else:
        assert found.state is StereoState.KNOWN and off[0] < TOL_M
