"""What has to be true of two cameras so that their images are a rectified pair."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_ROW_TOL_PX = 0.05
_FOCAL_TOL = 1e-4
_SQUARE_TOL = 1e-3


@dataclass(frozen=True, eq=False)
class CameraModel:
    """One camera as its `camera_info` has it.

    Attributes:
        size: Columns and rows.
        distortion: Of the raw image, (N,).
        intrinsics: K, (3, 3), of the raw image.
        rotation: R, (3, 3), that rectification applies.
        projection: P, (3, 4), of the rectified image.
    """

    size: tuple[int, int]
    distortion: np.ndarray
    intrinsics: np.ndarray
    rotation: np.ndarray
    projection: np.ndarray


@dataclass(frozen=True)
class RectifiedPair:
    """A pair whose rows correspond.

    Attributes:
        size: Columns and rows of each image.
        focal_px: Of both.
        baseline_m: From the left camera to the right one.
        center_shift_px: Left principal point's column less the right one's; what a point at
            infinity has for a disparity.
    """

    size: tuple[int, int]
    focal_px: float
    baseline_m: float
    center_shift_px: float


def rectified_pair(left: CameraModel, right: CameraModel) -> RectifiedPair:
    """Return what the two cameras are as a pair.

    Raises:
        ValueError: If they are none that is rectified; says why.
    """
    for side, camera in (("left", left), ("right", right)):
        require_rectified(side, camera)
    if left.size != right.size:
        raise ValueError(f"the images' sizes differ: {left.size} and {right.size}")
    fl, fr = float(left.projection[0, 0]), float(right.projection[0, 0])
    if abs(fl - fr) > _FOCAL_TOL * fl:
        raise ValueError(f"not rectified: focal lengths differ, {fl:g} and {fr:g} px")
    rows = [c.projection[1, 2] for c in (left, right)]
    if abs(rows[0] - rows[1]) > _ROW_TOL_PX:
        raise ValueError(f"not rectified: rows differ, {rows[0]:g} and {rows[1]:g} px")
    baseline = float((left.projection[0, 3] - right.projection[0, 3]) / fl)
    if baseline == 0.0:
        raise ValueError(
            "no baseline: P[0, 3] of both cameras is the same; calibrate them as a pair"
        )
    if baseline < 0.0:
        raise ValueError(f"left and right are exchanged: the baseline is {baseline:g} m")
    shift = float(left.projection[0, 2] - right.projection[0, 2])
    return RectifiedPair(left.size, float(fl), baseline, shift)


def require_rectified(name: str, camera: CameraModel) -> None:
    """Require that a camera's images may be used as a pinhole's with one focal length.

    Args:
        name: Which camera, for the reason.
        camera: The camera.

    Raises:
        ValueError: If it is not calibrated, or its images are not rectified; says why.
    """
    numbers = (camera.projection, camera.intrinsics, camera.rotation, camera.distortion)
    if not all(np.isfinite(part).all() for part in numbers):
        raise ValueError(f"the {name} camera_info holds numbers that are not finite")
    fx, fy = float(camera.projection[0, 0]), float(camera.projection[1, 1])
    if not fx > 0.0 or not fy > 0.0:
        raise ValueError(f"the {name} camera is not calibrated: P has no focal length")
    if abs(fx - fy) > _SQUARE_TOL * fx:
        raise ValueError(
            f"not rectified: the {name} P has focal lengths {fx:g} and {fy:g} px, they must be one"
        )
    is_raw = np.array_equal(camera.projection[:, :3], camera.intrinsics)
    is_turned = not np.allclose(camera.rotation, np.eye(3))
    if is_raw and camera.distortion.any() and not is_turned:
        raise ValueError(f"not rectified: the {name} P is K, yet the lens distorts")
