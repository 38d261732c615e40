"""The camera model of an omnidirectional camera with a hyperboloidal mirror (floor paper, eq. 26).

A pixel at radius R from the image center sees the floor at the distance

    r = R / (A - B sqrt(C + R^2))        (eq. 26; r in mm, R in pixels)

in the direction Phi = atan2(v - v0, u - u0), v running down. The camera looks up into the mirror:
its image x axis is the robot's forward axis and its image y axis (down) the robot's left, so that
Phi is the bearing seen from the robot (eq. 3) and no axis is flipped anywhere else. A, B and C
come from the mirror (b, c), the focal length f and the height H of its single viewpoint, and obey
A^2 / C - B^2 = 1 / H^2: with the paper's figures H = 205 mm. Seen from there the ray of a pixel
falls by H (A - B sqrt(C + R^2)) over R, also where that is negative and the ray climbs.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass, replace

import numpy as np

from floornav_common.cameras.central import fit_inside, is_in_view
from floornav_common.cameras.radial import axis_angle, offsets_at, offsets_jacobian
from floornav_common.config import param, validate

KIND = "hyperboloidal_mirror"
_MM = 1000.0


@dataclass(frozen=True, kw_only=True)
class MirrorCamera:
    """One camera of this kind at one image size."""

    width_px: int = param(MISSING, "Columns of the image.", unit="px", gt=0)
    height_px: int = param(MISSING, "Rows of the image.", unit="px", gt=0)
    a_px_per_mm: float = param(MISSING, "A of eq. 26.", unit="px/mm", gt=0.0)
    b_per_mm: float = param(MISSING, "B of eq. 26.", unit="1/mm", gt=0.0)
    c_px2: float = param(MISSING, "C of eq. 26, the focal length squared.", unit="px^2", gt=0.0)
    center_u_px: float = param(MISSING, "Column of the mirror's axis.", unit="px")
    center_v_px: float = param(MISSING, "Row of the mirror's axis.", unit="px")
    max_radius_px: float = param(MISSING, "Edge of the mirror in the image.", unit="px", gt=0.0)
    rotation_rad: float = param(0.0, "Bearing of the image's x axis.", unit="rad")

    def __post_init__(self) -> None:
        validate(self)
        if self.a_px_per_mm**2 / self.c_px2 <= self.b_per_mm**2:
            raise ValueError("a_px_per_mm^2 / c_px2 must be > b_per_mm^2: no viewpoint height else")

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the mirror's axis."""
        return self.center_u_px, self.center_v_px

    @property
    def is_symmetric(self) -> bool:
        """Whether the image is the same in all directions around its center: yes."""
        return True

    @property
    def viewpoint_height(self) -> float:
        """Height of the single viewpoint over the floor, m: 1 / H^2 = A^2 / C - B^2."""
        H_mm = (self.a_px_per_mm**2 / self.c_px2 - self.b_per_mm**2) ** -0.5
        return float(H_mm / _MM)

    @property
    def horizon_radius(self) -> float:
        """Pixel radius of the horizon, where the denominator of eq. 26 vanishes."""
        return math.sqrt((self.a_px_per_mm / self.b_per_mm) ** 2 - self.c_px2)

    def floor_distance(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return the distance on the floor that a pixel radius sees, m (eq. 26); inf above it."""
        R = np.asarray(radius_px, dtype=float)
        falling = self._denominator(R)
        safe = np.where(falling > 0.0, falling, 1.0)
        return np.where(falling > 0.0, R / safe / _MM, np.inf)

    def floor_slope(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return df/dR, m per pixel: how far a pixel reaches on the floor; inf above the horizon.

        dr/dR = (D + B R^2 / q) / D^2 with q = sqrt(C + R^2) and D = A - B q.
        """
        R = np.asarray(radius_px, dtype=float)
        D = self._denominator(R)
        safe = np.where(D > 0.0, D, 1.0)
        slope = (safe + self.b_per_mm * R**2 / np.sqrt(self.c_px2 + R**2)) / safe**2 / _MM
        return np.where(D > 0.0, slope, np.inf)

    def elevation(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return the angle over the horizon of the rays at a pixel radius, rad."""
        R = np.asarray(radius_px, dtype=float)
        return -np.arctan2(self.viewpoint_height * _MM * self._denominator(R), R)

    def image_radius(self, elevation: np.ndarray | float) -> np.ndarray:
        """Return the pixel radius at which a direction is seen; the inverse of `elevation`.

        With the ray's fall t = -tan(elevation), (H A - t R)^2 = (H B)^2 (C + R^2) and
        (H A)^2 - (H B)^2 C = C leave R = C / (H A t + H B sqrt(C (1 + t^2))). NaN for directions
        so steep that no mirror, however large, shows them.
        """
        angle = np.asarray(elevation, dtype=float)
        fall = self._image_fall(angle)
        return np.where(
            fall > 0.0, self.c_px2 * np.cos(angle) / np.where(fall > 0.0, fall, 1.0), np.nan
        )

    def image_slope(self, elevation: np.ndarray | float) -> np.ndarray:
        """Return dR/d(elevation), px per rad."""
        angle = np.asarray(elevation, dtype=float)
        c, s = np.cos(angle), np.sin(angle)
        fall = self._image_fall(angle)
        ha = self.viewpoint_height * _MM * self.a_px_per_mm
        slope = self.c_px2 * (ha * c**2 - s * fall) / np.where(fall > 0.0, fall, 1.0) ** 2
        return np.where(fall > 0.0, slope, np.nan)

    def floor_radius(self, distance: np.ndarray | float) -> np.ndarray:
        """Return the pixel radius at which the floor is seen at a distance, m."""
        return self.image_radius(-np.arctan2(self.viewpoint_height, np.asarray(distance)))

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors of pixels in the frame of the robot's axes at the viewpoint.

        Args:
            pixels: (u, v), shape (..., 2).

        Returns:
            Shape (..., 3): x forward, y left, z up.
        """
        X, Y = pixels[..., 0] - self.center_u_px, pixels[..., 1] - self.center_v_px
        elevation = self.elevation(np.hypot(X, Y))
        bearing = np.arctan2(Y, X) + self.rotation_rad
        flat = np.cos(elevation)
        return np.stack((flat * np.cos(bearing), flat * np.sin(bearing), np.sin(elevation)), -1)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) of points (..., 3) at the viewpoint; NaN where not seen."""
        turned = self._turned(points)
        R = self.image_radius(axis_angle(turned) - math.pi / 2.0)
        pixels = offsets_at(turned, R) + np.array(self.center_px)
        return np.where(self.sees(pixels)[..., None], pixels, np.nan)

    def project_jacobian(self, points: np.ndarray) -> np.ndarray:
        """Return d(u, v)/d(x, y, z) at points (..., 3), shape (..., 2, 3)."""
        turned = self._turned(points)
        elevation = axis_angle(turned) - math.pi / 2.0
        R, slope = self.image_radius(elevation), self.image_slope(elevation)
        return np.asarray(offsets_jacobian(turned, R, slope) @ self._turn())

    def sees(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether pixels (..., 2) are in the image and on the mirror."""
        size = self.width_px, self.height_px
        return is_in_view(pixels, size, self.center_px, self.max_radius_px)

    def resized(self, width_px: int, height_px: int) -> MirrorCamera:
        """Return the camera at another image size: the same picture, as large as fits inside.

        R scales by s, so A by s and C by s^2; B stays.
        """
        old, new = (self.width_px, self.height_px), (width_px, height_px)
        s, center = fit_inside(old, new, self.center_px)
        return replace(
            self,
            width_px=width_px,
            height_px=height_px,
            a_px_per_mm=self.a_px_per_mm * s,
            c_px2=self.c_px2 * s**2,
            center_u_px=center[0],
            center_v_px=center[1],
            max_radius_px=self.max_radius_px * s,
        )

    def _turn(self) -> np.ndarray:
        """Return the matrix from the link's axes to the image's frame, whose z points down."""
        c, s = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, -1.0]])

    def _turned(self, points: np.ndarray) -> np.ndarray:
        return np.asarray(points @ self._turn().T)

    def _image_fall(self, angle: np.ndarray) -> np.ndarray:
        """Return H (A s + B sqrt(C)), s the sine of the fall; stays finite straight down."""
        H, f = self.viewpoint_height * _MM, math.sqrt(self.c_px2)
        return np.asarray(H * (self.b_per_mm * f - self.a_px_per_mm * np.sin(angle)))

    def _denominator(self, R: np.ndarray) -> np.ndarray:
        return np.asarray(self.a_px_per_mm - self.b_per_mm * np.sqrt(self.c_px2 + R**2))


def paper_camera() -> MirrorCamera:
    """Return the floor paper's camera at its size: 256 x 220, the edge at 110 px."""
    return MirrorCamera(
        width_px=256,
        height_px=220,
        a_px_per_mm=10.12,
        b_per_mm=0.02054,
        c_px2=229800.0,
        center_u_px=127.5,
        center_v_px=109.5,
        max_radius_px=110.0,
    )
