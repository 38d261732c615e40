"""Small rooms of voxels, and what ideal stereo pairs see in them."""

import numpy as np

from multi_localizer.stereo_view import observe
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera, VoxelScene

CELL_M, LAYER_M = 0.02, 0.16
FRONT = ViewCamera(320, 240, 276.0, 0.1, 1.0, x_m=0.1, y_m=0.05)
REAR = ViewCamera(320, 240, 276.0, 0.1, 1.0, x_m=-0.1, y_m=-0.05, yaw=np.pi)
CAMERAS = (FRONT, REAR)


def room(width=3.2, depth=2.4, is_twofold=False, seed=0):
    """Return a room with its corner at 0, 0 and two boxes; walls are one cell thick, inside.

    With `is_twofold` it looks the same turned by 180 degrees about its middle.
    """
    rows, columns, layers = round(depth / CELL_M), round(width / CELL_M), 14
    occupied = np.zeros((layers, rows, columns), dtype=bool)
    occupied[[0, -1]] = True
    occupied[:, [0, -1]] = True
    occupied[:, :, [0, -1]] = True
    occupied[1:8, 10:30, 20:45] = True
    occupied[1:14, 60:75, 1:10] = True
    rng = np.random.default_rng(seed)
    patches = rng.integers(40, 250, (layers, rows // 10 + 1, columns // 10 + 1, 3))
    color = np.repeat(np.repeat(patches, 10, axis=1), 10, axis=2)[:, :rows, :columns]
    if is_twofold:
        occupied |= occupied[:, ::-1, ::-1]
        color = np.maximum(color, color[:, ::-1, ::-1])
    color = np.where(occupied[..., None], color, 0).astype(np.uint8)
    return VoxelMap(color, occupied, CELL_M, LAYER_M, 0.0, 0.0, -LAYER_M)


def views_at(voxels, pose, cameras=CAMERAS, noise_px=0.0, seed=0):
    """Return what ideal pairs see, with noise on the disparities."""
    scene, rng = VoxelScene(voxels), np.random.default_rng(seed)
    views = []
    for camera in cameras:
        size = camera.width_px, camera.height_px
        color, distance = scene.render(pose.as_array()[None], camera, size)
        disparity = camera.pixel_meters / distance[0]
        disparity += rng.normal(0.0, 1.0, disparity.shape) * noise_px
        image = np.rint(color[0]).astype(np.uint8)
        views.append(observe(disparity.astype(np.float32), image, camera, voxels.farthest_m))
    return views
