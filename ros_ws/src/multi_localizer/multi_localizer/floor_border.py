"""Border of the floor region in the image (floor paper, section 4, steps 2 and 3)."""

from __future__ import annotations

import cv2
import numpy as np


def row_extremes(mask: np.ndarray) -> np.ndarray:
    """Return the first and the last floor pixel of each row that has any (step 2).

    Args:
        mask: Not 0 where the floor is, (H, W), uint8.

    Returns:
        (u, v), first ones before last ones, (2 N, 2), float.
    """
    is_floor = mask != 0
    rows = np.flatnonzero(is_floor.any(axis=1))
    first = is_floor[rows].argmax(axis=1)
    last = mask.shape[1] - 1 - is_floor[rows, ::-1].argmax(axis=1)
    u, v = np.concatenate((first, last)), np.concatenate((rows, rows))
    return np.stack((u, v), axis=-1).astype(float)


def convex_hull(pixels: np.ndarray) -> np.ndarray:
    """Return the vertices of the convex hull of points (N, 2), in order, (M, 2) (step 3)."""
    if len(pixels) < 3:
        return pixels
    return np.asarray(cv2.convexHull(pixels.astype(np.float32))[:, 0], dtype=float)
