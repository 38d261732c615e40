"""OpenCV's matchers behind the same interface, as the peers that they are."""

from __future__ import annotations

import cv2
import numpy as np

from multi_localizer.stereo_cost import gray_of

_FRACTIONS = 16.0  # OpenCV's disparities are in sixteenths of a pixel


def match_bm(left: np.ndarray, right: np.ndarray, num_disparities: int) -> np.ndarray:
    """Return StereoBM's disparities, (H, W) float32, NaN where it gives none.

    Args:
        left: (H, W) or (H, W, 3), uint8.
        right: The same.
        num_disparities: Disparities searched.
    """
    matcher = cv2.StereoBM_create(numDisparities=num_disparities, blockSize=9)  # type: ignore[attr-defined]
    return _padded(matcher, gray_of(left), gray_of(right), num_disparities)


def match_sgbm(
    left: np.ndarray, right: np.ndarray, num_disparities: int, **settings: int
) -> np.ndarray:
    """Return StereoSGBM's disparities (5 directions), (H, W) float32, NaN where it gives none.

    Args:
        left: (H, W) or (H, W, 3), uint8.
        right: The same.
        num_disparities: Disparities searched.
        settings: Of `cv2.StereoSGBM_create`, in place of ours.
    """
    return _padded(sgbm(left.ndim, num_disparities, **settings), left, right, num_disparities)


def sgbm(ndim: int, num_disparities: int, **settings: int) -> cv2.StereoSGBM:
    """Return a StereoSGBM; what is not said is as OpenCV's documentation advises."""
    block = settings.get("blockSize", 3)
    area = (3 if ndim == 3 else 1) * block * block
    values = {
        "minDisparity": 0, "numDisparities": num_disparities, "blockSize": block, "P1": 8 * area,
        "P2": 32 * area, "disp12MaxDiff": 1, "preFilterCap": 15, "uniquenessRatio": 0,
        "mode": cv2.StereoSGBM_MODE_SGBM,
    }  # fmt: skip
    return cv2.StereoSGBM_create(**{**values, **settings})  # type: ignore[attr-defined]


def _padded(
    matcher: cv2.StereoMatcher, left: np.ndarray, right: np.ndarray, num_disparities: int
) -> np.ndarray:
    """Match with columns added on the left: OpenCV leaves out the first `num_disparities`."""
    wide = [
        cv2.copyMakeBorder(image, 0, 0, num_disparities, 0, cv2.BORDER_REPLICATE)
        for image in (left, right)
    ]
    found = matcher.compute(*wide)[:, num_disparities:].astype(np.float32) / _FRACTIONS
    found[found < 0.0] = np.nan
    return found
