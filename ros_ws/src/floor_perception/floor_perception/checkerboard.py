"""Finds a checkerboard's corners, and the edge of the view, in wide-angle pictures."""

from __future__ import annotations

import cv2
import numpy as np

MIN_FILL = 0.93
"""Share of its enclosing circle that a bright disk must fill to be the edge of the view."""
MIN_SHARE, MAX_SHARE = 0.05, 0.9
"""Share of the picture that it takes."""


def board_points(pattern: tuple[int, int]) -> np.ndarray:
    """Return the corners of a pattern of (columns, rows), in squares, shape (N, 2), row by row."""
    rows, columns = np.mgrid[: pattern[1], : pattern[0]]
    return np.stack((columns.ravel(), rows.ravel()), axis=-1).astype(float)


def find_corners(gray: np.ndarray, pattern: tuple[int, int]) -> np.ndarray | None:
    """Return the inner corners of a board to a part of a pixel, shape (N, 2); None if not found.

    The sector-based detector of Duda and Frese (2018), which stands the bent lines of a mirror; at
    first as it is, then with the exhaustive search, which takes seconds.

    Args:
        gray: Shape (H, W), uint8.
        pattern: Inner corners along columns and rows of the board.
    """
    for flags in (cv2.CALIB_CB_ACCURACY, cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE):
        found, corners = cv2.findChessboardCornersSB(gray, pattern, flags=flags)
        if found:
            return np.asarray(corners, dtype=float).reshape(-1, 2)
    return None


def find_edge(gray: np.ndarray) -> tuple[float, float, float] | None:
    """Return center (u, v) and radius of the bright disk that a mirror or round lens shows, px.

    Args:
        gray: Shape (H, W), uint8; the mean of several pictures is better than one.

    Returns:
        None where the picture has no such disk, as of lenses that fill it.
    """
    blurred = cv2.GaussianBlur(gray, (0, 0), max(gray.shape) / 400.0)
    bright = cv2.threshold(blurred, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[1]
    outlines = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    large = [outline for outline in outlines if len(outline) > MIN_SHARE * len(gray)]
    if not large:
        return None
    hull = cv2.convexHull(np.concatenate(large))
    (u, v), radius = cv2.minEnclosingCircle(hull)
    area = cv2.contourArea(hull)
    if area < MIN_FILL * np.pi * radius**2:
        return None
    if not MIN_SHARE * gray.size < area < MAX_SHARE * gray.size:
        return None
    return float(u), float(v), float(radius)
