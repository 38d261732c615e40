"""A fisheye whose radius grows with the angle from its axis (Kannala and Brandt 2006; OpenCV).

    theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
    u = cx + fx theta_d x / |q|,   v = cy + fy theta_d y / |q|

with q = (x, y) in the image's frame. `cv2.fisheye` and kalibr's `equidistant` give these very
figures; unlike OpenCV's functions, these go on past 90 degrees.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass, replace

import numpy as np

from floornav_common.cameras.central import LOOKS, fit_inside, is_in_view, optical_axes
from floornav_common.cameras.radial import axis_angle, offsets_at, offsets_jacobian, rays_at
from floornav_common.cameras.rising import solve_rising
from floornav_common.config import param, validate

KIND = "equidistant"


@dataclass(frozen=True, kw_only=True)
class EquidistantCamera:
    """One camera of this kind at one image size."""

    width_px: int = param(MISSING, "Columns of the image.", unit="px", gt=0)
    height_px: int = param(MISSING, "Rows of the image.", unit="px", gt=0)
    fx_px: float = param(MISSING, "Focal length along the rows.", unit="px", gt=0.0)
    fy_px: float = param(MISSING, "Focal length along the columns.", unit="px", gt=0.0)
    center_u_px: float = param(MISSING, "Column of the optical axis (cx).", unit="px")
    center_v_px: float = param(MISSING, "Row of the optical axis (cy).", unit="px")
    k1: float = param(0.0, "Distortion, theta^3.")
    k2: float = param(0.0, "Distortion, theta^5.")
    k3: float = param(0.0, "Distortion, theta^7.")
    k4: float = param(0.0, "Distortion, theta^9.")
    max_angle_rad: float = param(
        math.pi / 2.0, "Edge of the view, from the optical axis.", unit="rad", gt=0.0, le=math.pi
    )
    looks: str = param("down", "Where the camera looks.", choices=LOOKS)

    def __post_init__(self) -> None:
        validate(self)
        angles = np.linspace(0.0, self.max_angle_rad, 361)
        if not (self._slope(angles) > 0.0).all():
            first = math.degrees(float(angles[self._slope(angles) <= 0.0][0]))
            raise ValueError(f"k1 to k4 fold the image {first:.0f} deg from the axis")

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the optical axis."""
        return self.center_u_px, self.center_v_px

    @property
    def is_symmetric(self) -> bool:
        """Whether the image is the same around an upright axis: both focal lengths are one."""
        return self.fx_px == self.fy_px and self.looks != "forward"

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors (..., 3) of pixels (..., 2); NaN beyond `max_angle_rad`."""
        offsets = (np.asarray(pixels, dtype=float) - self.center_px) / (self.fx_px, self.fy_px)
        angle = self._angle(np.hypot(offsets[..., 0], offsets[..., 1]))
        return np.asarray(rays_at(offsets, angle) @ optical_axes(self.looks).T)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) of points (..., 3) at the viewpoint; NaN where not seen."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        angle = axis_angle(turned)
        flat = offsets_at(turned, np.where(angle <= self.max_angle_rad, self._bent(angle), np.nan))
        pixels = flat * (self.fx_px, self.fy_px) + self.center_px
        return np.where(self.sees(pixels)[..., None], pixels, np.nan)

    def project_jacobian(self, points: np.ndarray) -> np.ndarray:
        """Return d(u, v)/d(x, y, z) at points (..., 3), shape (..., 2, 3)."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        angle = axis_angle(turned)
        flat = offsets_jacobian(turned, self._bent(angle), self._slope(angle))
        return np.asarray(np.diag((self.fx_px, self.fy_px)) @ flat @ optical_axes(self.looks).T)

    def sees(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether pixels (..., 2) are in the image and within `max_angle_rad`."""
        pixels = np.asarray(pixels, dtype=float)
        flat = (pixels - self.center_px) / (self.fx_px, self.fy_px)
        edge = float(self._bent(np.array(self.max_angle_rad)))
        size = self.width_px, self.height_px
        with np.errstate(invalid="ignore"):
            is_within = np.hypot(flat[..., 0], flat[..., 1]) <= edge * (1.0 + 1e-12)
        return np.asarray(is_within & is_in_view(pixels, size, self.center_px, math.inf))

    def resized(self, width_px: int, height_px: int) -> EquidistantCamera:
        """Return the camera at another image size: the same picture, as large as fits inside."""
        old, new = (self.width_px, self.height_px), (width_px, height_px)
        s, (u, v) = fit_inside(old, new, self.center_px)
        return replace(
            self, width_px=width_px, height_px=height_px, fx_px=s * self.fx_px,
            fy_px=s * self.fy_px, center_u_px=u, center_v_px=v,
        )  # fmt: skip

    def _bent(self, angle: np.ndarray) -> np.ndarray:
        """Return theta_d."""
        t2 = angle**2
        return np.asarray(
            angle * (1.0 + t2 * (self.k1 + t2 * (self.k2 + t2 * (self.k3 + t2 * self.k4))))
        )

    def _slope(self, angle: np.ndarray) -> np.ndarray:
        """Return d(theta_d)/d(theta)."""
        t2, (k1, k2, k3, k4) = angle**2, (self.k1, self.k2, self.k3, self.k4)
        return np.asarray(1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4))))

    def _angle(self, bent: np.ndarray) -> np.ndarray:
        """Return theta of theta_d; NaN beyond `max_angle_rad`."""
        end = self._bent(np.array(self.max_angle_rad))
        with np.errstate(invalid="ignore"):
            target = np.where(bent <= end * (1.0 + 1e-12), np.minimum(bent, end), np.nan)
        return solve_rising(
            self._bent, self._slope, target, np.zeros(()), np.array(self.max_angle_rad)
        )
