"""A camera over a plane floor: from pixels to metres and back (floor paper, eq. 1 to 6).

Any central camera, mounted at a height and tilted or not. Points are in `omni_camera_floor`: on the
floor below the camera, z up, x as base_link.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from floornav_common.calibration import Calibration, check_names, resized_calibration
from floornav_common.cameras.central import CentralCamera


@dataclass(frozen=True)
class FloorCamera:
    """A camera and how it stands over the floor.

    Attributes:
        camera: The camera's model.
        height_m: Height of its viewpoint over the floor.
        roll_rad: Turn of the camera's link about x, first.
        pitch_rad: Turn about y, second; positive looks down in front.
        yaw_rad: Turn about z, last: the bearing of the link's x axis.
        position_m: Where the viewpoint is over base_link's x and y.
        calibration: How well these are known; None: exactly.
    """

    camera: CentralCamera
    height_m: float
    roll_rad: float = 0.0
    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
    position_m: tuple[float, float] = (0.0, 0.0)
    calibration: Calibration | None = None

    def __post_init__(self) -> None:
        numbers = (self.roll_rad, self.pitch_rad, self.yaw_rad, *self.position_m)
        if not (0.0 < self.height_m < math.inf):
            raise ValueError(f"height_m must be > 0 and finite, got {self.height_m}")
        if not all(math.isfinite(n) for n in numbers):
            raise ValueError(f"roll, pitch, yaw and position must be finite, got {numbers}")
        if self.calibration is not None:
            check_names(self)

    @property
    def width_px(self) -> int:
        """Columns of the image."""
        return self.camera.width_px

    @property
    def height_px(self) -> int:
        """Rows of the image."""
        return self.camera.height_px

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the optical axis."""
        return self.camera.center_px

    @property
    def is_radial(self) -> bool:
        """Whether a pixel's distance on the floor is a function of its radius: r = f(R) (eq. 4)."""
        return self.camera.is_symmetric and self.roll_rad == 0.0 and self.pitch_rad == 0.0

    @property
    def rotation(self) -> np.ndarray:
        """Matrix (3, 3) from the link's axes to those of the floor's frame."""
        angles = (self.yaw_rad, self.pitch_rad, self.roll_rad)
        return np.asarray(Rotation.from_euler("ZYX", angles).as_matrix())

    def floor_rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors (..., 3) of pixels (..., 2) in the floor's axes; NaN where unseen."""
        pixels = np.asarray(pixels, dtype=float)
        rays = self.camera.rays(pixels) @ self.rotation.T
        return np.where(self.camera.sees(pixels)[..., None], rays, np.nan)

    def floor_points(self, pixels: np.ndarray) -> np.ndarray:
        """Return the points on the floor that pixels see.

        Args:
            pixels: (u, v), shape (..., 2).

        Returns:
            (x, y), shape (..., 2), m; (inf, inf) for pixels that look at or above the horizon, NaN
            for those that see nothing.
        """
        rays = self.floor_rays(pixels)
        fall = -rays[..., 2:]
        with np.errstate(invalid="ignore"):
            is_falling = fall > 0.0
        points = self.height_m * rays[..., :2] / np.where(is_falling, fall, 1.0)
        return np.where(is_falling, points, np.where(np.isnan(fall), np.nan, np.inf))

    def floor_pixels(self, points_floor: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) that see points (x, y) on the floor; NaN where none does."""
        return self.camera.project(self._points_link(points_floor))

    def floor_jacobian(self, pixels: np.ndarray) -> np.ndarray:
        """Return d(x, y)/d(u, v) of `floor_points`, shape (..., 2, 2), m per pixel.

        NaN where no floor is seen. A pixel's noise of covariance S is J S J^T on the floor.
        """
        points = self.floor_points(pixels)
        points = np.where(np.isfinite(points), points, np.nan)
        by_point = self.camera.project_jacobian(self._points_link(points))
        return _inverse_2x2(by_point @ self.rotation.T[:, :2])

    def floor_distance(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return r = f(R), m (eq. 4); inf at and above the horizon, NaN where nothing is seen.

        Raises:
            ValueError: The camera is tilted, or its image differs from direction to direction.
        """
        points = self.floor_points(self._radial_pixels(radius_px))
        return np.hypot(points[..., 0], points[..., 1])

    def radial_scale(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return df/dR, m per pixel; inf at and above the horizon, NaN where nothing is seen.

        Raises:
            ValueError: The camera is tilted, or its image differs from direction to direction.
        """
        pixels = self._radial_pixels(radius_px)
        scale = np.hypot(*np.moveaxis(self.floor_jacobian(pixels)[..., 0], -1, 0))
        return np.where(np.isinf(self.floor_points(pixels)[..., 0]), np.inf, scale)

    def seen_mask(self) -> np.ndarray:
        """Return which pixels see anything, shape (height_px, width_px), bool."""
        return self.camera.sees(self._all_pixels())

    def floor_mask(self, max_distance_m: float = math.inf) -> np.ndarray:
        """Return which pixels see floor nearer than a distance, (height_px, width_px), bool."""
        points = self.floor_points(self._all_pixels())
        return np.asarray(np.hypot(points[..., 0], points[..., 1]) < max_distance_m)

    def resized(self, width_px: int, height_px: int) -> FloorCamera:
        """Return the camera at another image size: the same picture, as large as fits inside."""
        calibration = resized_calibration(self, width_px, height_px)
        return replace(
            self, camera=self.camera.resized(width_px, height_px), calibration=calibration
        )

    def _points_link(self, points_floor: np.ndarray) -> np.ndarray:
        points = np.asarray(points_floor, dtype=float)
        below = np.full((*points.shape[:-1], 1), -self.height_m)
        return np.asarray(np.concatenate((points, below), axis=-1) @ self.rotation)

    def _radial_pixels(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return pixels at radii, in the direction in which the image reaches farthest."""
        if not self.is_radial:
            raise ValueError("r = f(R) holds for an upright camera with a round image only")
        R = np.asarray(radius_px, dtype=float)
        (u, v), (width, height) = self.center_px, (self.width_px, self.height_px)
        ways = {(1, 0): width - 1 - u, (-1, 0): u, (0, 1): height - 1 - v, (0, -1): v}
        return np.asarray(
            np.array((u, v)) + R[..., None] * np.array(max(ways, key=lambda w: ways[w]))
        )

    def _all_pixels(self) -> np.ndarray:
        v, u = np.mgrid[: self.height_px, : self.width_px]
        return np.stack((u, v), axis=-1).astype(float)


def _inverse_2x2(matrices: np.ndarray) -> np.ndarray:
    a, b = matrices[..., 0, 0], matrices[..., 0, 1]
    c, d = matrices[..., 1, 0], matrices[..., 1, 1]
    adjugate = np.stack((np.stack((d, -b), -1), np.stack((-c, a), -1)), -2)
    return np.asarray(adjugate / (a * d - b * c)[..., None, None])
