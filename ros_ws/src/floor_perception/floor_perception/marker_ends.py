"""The bearings of both ends of a wide marker, such as the posts of a goal."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.floor_camera import FloorCamera


def bearings_of_ends(pixels: np.ndarray, middle: float, camera: FloorCamera) -> tuple[float, float]:
    """Return the bearings of the right and the left end of a blob, rad.

    The outermost pixels' middles lie half a pixel inside of the ends.

    Args:
        pixels: Of the blob, (u, v), shape (N, 2).
        middle: Bearing of its middle, rad; the blob must not reach to behind it.
        camera: That sees it.
    """
    rays = camera.floor_rays(pixels)
    off = np.remainder(np.arctan2(rays[:, 1], rays[:, 0]) - middle + math.pi, 2.0 * math.pi)
    half = 0.5 / np.maximum(np.hypot(*(pixels - np.array(camera.center_px)).T), 1.0)
    right, left = int(off.argmin()), int(off.argmax())
    return (
        math.remainder(middle + float(off[right] - half[right]) - math.pi, 2.0 * math.pi),
        math.remainder(middle + float(off[left] + half[left]) - math.pi, 2.0 * math.pi),
    )
