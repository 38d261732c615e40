"""The camera at the size that its images have."""

from __future__ import annotations

from floornav_common.floor_camera import FloorCamera

_MAX_RATIO = 1.25


def camera_at_size(camera: FloorCamera, height: int, width: int) -> FloorCamera:
    """Return a camera for images of a size: the same picture, as large as fits inside.

    A little more at two sides is taken for a border, as 640 x 480 has beside 256 x 220. What is
    much wider or higher, or turned on its side, is another camera's picture.

    Raises:
        ValueError: The shapes differ by more than a quarter.
    """
    own = camera.width_px, camera.height_px
    if (width, height) == own:
        return camera
    if min(width, height) < 1:
        raise ValueError(f"image must not be empty, got {width} x {height}")
    ratio = (width / height) / (own[0] / own[1])
    if not 1.0 / _MAX_RATIO <= ratio <= _MAX_RATIO:
        raise ValueError(
            f"image must be as wide for its height as the camera's {own[0]} x {own[1]}, to a "
            f"quarter, got {width} x {height}"
        )
    return camera.resized(width, height)
