"""What every camera model here can do, and how a camera stands on its link.

A central camera has one viewpoint: each pixel stands for a ray from it. Rays and points are in the
axes of the camera's link at the viewpoint, x forward, y left, z up (REP 103); pixels are (u, v)
with v running down, and pixel centers have whole numbers.
"""

from __future__ import annotations

from typing import Protocol, Self

import numpy as np

LOOKS = ("mirror_above", "down", "up", "forward")


class CentralCamera(Protocol):
    """One camera at one image size. All methods take any leading shape."""

    @property
    def width_px(self) -> int:
        """Columns of the image."""
        ...

    @property
    def height_px(self) -> int:
        """Rows of the image."""
        ...

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the optical axis."""
        ...

    @property
    def is_symmetric(self) -> bool:
        """Whether the image is the same in all directions around an upright axis."""
        ...

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors (..., 3) of pixels (..., 2); NaN where the model has no ray.

        The edge of the view plays no part: ask `sees` for that.
        """
        ...

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) at which points (..., 3) are seen; NaN where they are not."""
        ...

    def project_jacobian(self, points: np.ndarray) -> np.ndarray:
        """Return d(u, v)/d(x, y, z) at points (..., 3), shape (..., 2, 3)."""
        ...

    def sees(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether pixels (..., 2) are in the image and within the edge of the view."""
        ...

    def resized(self, width_px: int, height_px: int) -> Self:
        """Return the camera at another image size: the same picture, as large as fits inside."""
        ...


def optical_axes(looks: str) -> np.ndarray:
    """Return the matrix (3, 3) that takes rays of the image's frame to the link's axes.

    The image's frame has x to the right in the image, y down, z where the image's center looks.

    Args:
        looks: `up` or `down`: right in the image is the robot's front. `forward`: as a pinhole
            camera. `mirror_above`: a camera that looks up into a mirror: right in the image is the
            front and down its left, as for `up`, but the center sees down: this matrix reflects.
    """
    matrices = {
        "up": np.eye(3),
        "mirror_above": np.diag((1.0, 1.0, -1.0)),
        "down": np.diag((1.0, -1.0, -1.0)),
        "forward": np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    }
    if looks not in matrices:
        raise ValueError(f"looks must be one of {', '.join(LOOKS)}, got {looks!r}")
    return matrices[looks]


def is_in_view(
    pixels: np.ndarray,
    size_px: tuple[int, int],
    center_px: tuple[float, float],
    max_radius_px: float,
) -> np.ndarray:
    """Return whether pixels (..., 2) are in the image and within a radius of its center."""
    u, v = pixels[..., 0], pixels[..., 1]
    with np.errstate(invalid="ignore"):
        is_inside = (u >= -0.5) & (u < size_px[0] - 0.5) & (v >= -0.5) & (v < size_px[1] - 0.5)
        return np.asarray(
            is_inside & (np.hypot(u - center_px[0], v - center_px[1]) <= max_radius_px)
        )


def fit_inside(
    old_px: tuple[int, int], new_px: tuple[int, int], center_px: tuple[float, float]
) -> tuple[float, tuple[float, float]]:
    """Return the scale and the new center of a picture made as large as fits into a new size.

    The middle stays the middle; it is that of `cv2.resize` where the sizes are in proportion.
    """
    scale = min(new_px[0] / old_px[0], new_px[1] / old_px[1])
    u, v = (
        (new - 1) / 2.0 + scale * (at - (old - 1) / 2.0)
        for new, old, at in zip(new_px, old_px, center_px, strict=True)
    )
    return scale, (u, v)
