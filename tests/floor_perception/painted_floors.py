"""Images of a floor painted pixel by pixel, whose free space is known by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.floor_camera import FloorCamera

GREEN, GRAY, WHITE, BROWN = (26, 115, 41), (150, 150, 150), (240, 240, 235), (150, 110, 70)
Region = Callable[[np.ndarray, np.ndarray], np.ndarray]


def pixels(color: tuple[int, int, int], num: int, seed: int = 0) -> np.ndarray:
    """Return noisy pixels of a color, (num, 3), uint8."""
    noise = np.random.default_rng(seed).normal(0.0, 3.0, (num, 3))
    return np.clip(np.rint(np.array(color) + noise), 0, 255).astype(np.uint8)


def upright_camera(size: tuple[int, int] = (256, 220)) -> FloorCamera:
    """Return the paper's camera at an image size."""
    camera = paper_camera()
    return FloorCamera(camera.resized(*size), camera.viewpoint_height)


def painted(
    camera: FloorCamera,
    regions: list[tuple[Region, tuple[int, int, int]]],
    noise_sd: float = 0.0,
    light: float = 1.0,
    floor: tuple[int, int, int] = GREEN,
) -> np.ndarray:
    """Return an RGB image of a floor with regions painted over it, black where nothing is seen.

    Args:
        camera: The camera.
        regions: Which points (x, y) on the floor have a color; later ones lie above earlier ones.
            Points above the horizon are inf.
        noise_sd: Deviation of each value.
        light: Factor of all colors.
        floor: Color of the floor.
    """
    v, u = np.mgrid[: camera.height_px, : camera.width_px]
    points = camera.floor_points(np.stack((u, v), -1).astype(float))
    x, y = points[..., 0], points[..., 1]
    image = np.zeros((camera.height_px, camera.width_px, 3))
    image[:] = floor
    with np.errstate(invalid="ignore"):
        for region, color in regions:
            image[region(x, y)] = color
    image = image * light + np.random.default_rng(0).normal(0.0, noise_sd, image.shape)
    image[np.isnan(x)] = 0.0
    image[np.isinf(x)] = 200.0
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def behind(bearing: float, half_width: float, distance: float) -> Region:
    """Return what an upright wall across a sector hides: all from a distance on."""

    def region(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        off = np.angle(np.exp(1j * (np.arctan2(y, x) - bearing)))
        return np.asarray((np.hypot(x, y) >= distance) & (np.abs(off) <= half_width))

    return region


def robot_body(radius: float = 0.15) -> Region:
    """Return what the robot hides of the floor."""
    return lambda x, y: np.hypot(x, y) < radius
