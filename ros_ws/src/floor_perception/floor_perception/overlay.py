"""Floor region and free space drawn over the image, for people."""

from __future__ import annotations

import cv2
import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.scan import Scan

_FLOOR_BGR, _EDGE_BGR, _UNSEEN_BGR = (80, 200, 80), (40, 40, 255), (160, 160, 160)
_TINT = 0.35


def overlay(image_bgr: np.ndarray, mask: np.ndarray, scan: Scan, camera: FloorCamera) -> np.ndarray:
    """Return a copy of the image with the floor tinted and the free space outlined, BGR.

    Red: the end of the free floor in a direction; a gray mark at the first ring: not seen.
    """
    picture = image_bgr.copy()
    is_floor = mask > 0
    tint = np.array(_FLOOR_BGR, dtype=float)
    picture[is_floor] = ((1.0 - _TINT) * picture[is_floor] + _TINT * tint).astype(np.uint8)
    reach = np.clip(np.nan_to_num(scan.ranges, nan=scan.range_min), scan.range_min, scan.range_max)
    half = 0.5 * scan.angle_increment
    for range_, angle, raw in zip(reach, scan.angles, scan.ranges, strict=True):
        turns = angle + np.array((-half, half))
        points = range_ * np.stack((np.cos(turns), np.sin(turns)), -1)
        ends = camera.floor_pixels(points)
        if np.isfinite(ends).all():
            a, b = (tuple(int(round(float(c))) for c in end) for end in ends)
            color = _UNSEEN_BGR if np.isnan(raw) else _EDGE_BGR
            cv2.line(picture, a, b, color, 1, cv2.LINE_AA)
    return picture
