"""The camera at the size that its images have."""

from __future__ import annotations

from floornav_common.floor_camera import FloorCamera

_MAX_RATIO = 1.15
_ROUNDING_PX = 2.0


def camera_at_size(camera: FloorCamera, height: int, width: int) -> FloorCamera:
    """Return a camera for images of a size: the same picture, as large as fits inside.

    A little more at two sides is taken for a border, as 640 x 480 has beside 256 x 220; see
    `shape_doubt`. What is much wider or higher, or turned on its side, is another camera's picture.

    Raises:
        ValueError: The shapes differ by more than 15 %.
    """
    own = camera.width_px, camera.height_px
    if (width, height) == own:
        return camera
    if min(width, height) < 1:
        raise ValueError(f"image must not be empty, got {width} x {height}")
    ratio = (width / height) / (own[0] / own[1])
    if not 1.0 / _MAX_RATIO <= ratio <= _MAX_RATIO:
        raise ValueError(
            f"image must be as wide for its height as the {own[0]} x {own[1]} that camera_model is "
            f"for, to {_MAX_RATIO - 1.0:.0%}, got {width} x {height}"
        )
    return camera.resized(width, height)


def shape_doubt(camera: FloorCamera, height: int, width: int) -> str:
    """Return what is doubtful about images of a size that `camera_at_size` takes; "" if nothing.

    Args:
        camera: As calibrated.
        height: Of the images, px.
        width: Of the images, px.
    """
    own_width, own_height = camera.width_px, camera.height_px
    scale = min(width / own_width, height / own_height)
    aside, above = width - scale * own_width, height - scale * own_height
    if max(aside, above) <= _ROUNDING_PX:
        return ""
    where = "left and right" if aside > above else "above and below"
    return (
        f"images are {width} x {height}, camera_model is for {own_width} x {own_height}: taken as "
        f"the same picture {scale:.3g} times as large, with a border of "
        f"{max(aside, above) / 2.0:.0f} pixels {where}; ranges and bearings are wrong if they are "
        "another camera's, or cut"
    )
