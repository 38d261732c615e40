"""Poses in the rooms of `voxel_rooms`, and what is checked of those found."""

import numpy as np
from voxel_rooms import CAMERAS

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference
from multi_localizer.stereo_view import StereoView

TOL_M, TOL_RAD = 0.02, 0.01
POSES = (SE2(1.6, 1.2, 0.4), SE2(2.3, 1.6, -2.2), SE2(1.3, 1.7, 2.9))
SMALL = {"panorama_columns": 64, "num_refined": 20, "max_hypotheses": 4}


def assert_at(found, pose, tol=TOL_M, tol_rad=TOL_RAD):
    off = difference(found.pose, pose)
    assert np.hypot(off[0], off[1]) < tol
    assert abs(off[2]) < tol_rad


def blind_views():
    shape = (8, 320)
    nothing = np.full(shape, np.nan, np.float32)
    color = np.full((*shape, 3), 10.0, np.float32)
    return [StereoView(color, nothing, nothing, np.zeros(shape, np.float32)) for _ in CAMERAS]


def turned(pose):
    """The pose that looks the same in the twofold room."""
    return SE2(3.2 - pose.x, 2.4 - pose.y, pose.yaw + np.pi)
