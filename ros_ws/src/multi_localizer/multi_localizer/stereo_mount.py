"""A pair's left camera on the robot, from what its messages and TF say."""

from __future__ import annotations

import math

import numpy as np

from multi_localizer.stereo_cameras import CameraModel, require_rectified
from multi_localizer.voxel_view import ViewCamera

_LEVEL = math.sin(math.radians(3.0))
_FOCAL_TOL = 0.01


def mounted_camera(
    T_base_camera: np.ndarray, model: CameraModel, focal_px: float, baseline_m: float
) -> ViewCamera:
    """Return a camera that looks level.

    Args:
        T_base_camera: Pose of its optical frame (x right, y down, z along the view), (4, 4).
        model: Its camera_info.
        focal_px: As the disparities have it.
        baseline_m: The same.

    Raises:
        ValueError: If it is not rectified, does not look level, or the disparities are of another
            camera.
    """
    require_rectified("left", model)
    if not np.isfinite(T_base_camera).all():
        raise ValueError("TF holds numbers that are not finite")
    if not (np.isfinite(focal_px) and np.isfinite(baseline_m)):
        raise ValueError(
            f"the disparities' focal length {focal_px:g} px and baseline {baseline_m:g} m must be "
            "finite"
        )
    R, (x, y, z) = T_base_camera[:3, :3], T_base_camera[:3, 3].tolist()
    if abs(R[2, 2]) > _LEVEL or abs(R[2, 0]) > _LEVEL:
        tilt = math.degrees(math.asin(min(max(abs(R[2, 2]), abs(R[2, 0])), 1.0)))
        raise ValueError(
            f"the camera is tilted by {tilt:.0f} degrees, it must look level: is its frame an "
            "optical one (z along the view)?"
        )
    if R[2, 1] > 0.0:
        raise ValueError("the camera is upside down: y of its optical frame must point down")
    projection = model.projection
    if abs(projection[0, 0] - focal_px) > _FOCAL_TOL * focal_px:
        raise ValueError(
            f"the disparities' focal length is {focal_px:g} px, camera_info's {projection[0, 0]:g}"
        )
    yaw = math.atan2(R[1, 2], R[0, 2])
    width, height = model.size
    return ViewCamera(
        width, height, float(focal_px), float(baseline_m), z, x, y, yaw,
        float(projection[0, 2]), float(projection[1, 2]),
    )  # fmt: skip
