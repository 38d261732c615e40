"""A camera known by a table: pixel radii and the distances on the floor seen there.

For mirrors and lenses that no formula fits. Between the measured radii the angle from straight
down, theta = atan(r / H), is interpolated by monotone cubics (PCHIP) and not r itself, which runs
away towards the horizon; at radius 0 the camera sees straight down. Nothing is seen beyond the
last radius.
"""

from __future__ import annotations

import functools
from dataclasses import MISSING, dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from floornav_common.cameras.central import fit_inside, is_in_view, optical_axes
from floornav_common.cameras.radial import axis_angle, offsets_at, offsets_jacobian, rays_at
from floornav_common.cameras.rising import solve_rising
from floornav_common.config import param, validate

KIND = "radius_table"
_TABLE_LOOKS = ("mirror_above", "down")


@dataclass(frozen=True, kw_only=True)
class RadiusTableCamera:
    """One camera of this kind at one image size."""

    width_px: int = param(MISSING, "Columns of the image.", unit="px", gt=0)
    height_px: int = param(MISSING, "Rows of the image.", unit="px", gt=0)
    center_u_px: float = param(MISSING, "Column of the upright axis.", unit="px")
    center_v_px: float = param(MISSING, "Row of the upright axis.", unit="px")
    radii_px: tuple[float, ...] = param(MISSING, "Radii R, growing.", unit="px", gt=0.0)
    distances_m: tuple[float, ...] = param(MISSING, "Distances r, growing.", unit="m", gt=0.0)
    measured_height_m: float = param(
        MISSING, "Height of the viewpoint when r was measured.", unit="m", gt=0.0
    )
    looks: str = param("mirror_above", "Where the camera looks.", choices=_TABLE_LOOKS)

    def __post_init__(self) -> None:
        validate(self)
        if len(self.radii_px) != len(self.distances_m) or len(self.radii_px) < 2:
            raise ValueError(
                "radii_px and distances_m must be of one length >= 2, got "
                f"{len(self.radii_px)} and {len(self.distances_m)}"
            )
        for name in ("radii_px", "distances_m"):
            if not (np.diff(getattr(self, name)) > 0.0).all():
                raise ValueError(f"{name} must grow from entry to entry")

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the upright axis."""
        return self.center_u_px, self.center_v_px

    @property
    def max_radius_px(self) -> float:
        """Edge of what was measured."""
        return self.radii_px[-1]

    @property
    def viewpoint_height(self) -> float:
        """Height of the viewpoint over the floor, m."""
        return self.measured_height_m

    @property
    def is_symmetric(self) -> bool:
        """Whether the image is the same in all directions around its center: yes."""
        return True

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors (..., 3) of pixels (..., 2); NaN beyond the last radius."""
        offsets = np.asarray(pixels, dtype=float) - self.center_px
        angle = self._curve(np.hypot(offsets[..., 0], offsets[..., 1]))
        return np.asarray(rays_at(offsets, angle) @ optical_axes(self.looks).T)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) of points (..., 3) at the viewpoint; NaN where not seen."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        pixels = offsets_at(turned, self._radius(axis_angle(turned))) + self.center_px
        return np.where(self.sees(pixels)[..., None], pixels, np.nan)

    def project_jacobian(self, points: np.ndarray) -> np.ndarray:
        """Return d(u, v)/d(x, y, z) at points (..., 3), shape (..., 2, 3)."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        R = self._radius(axis_angle(turned))
        slope = 1.0 / self._curve(R, 1)
        return np.asarray(offsets_jacobian(turned, R, slope) @ optical_axes(self.looks).T)

    def sees(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether pixels (..., 2) are in the image and within the last radius."""
        size = self.width_px, self.height_px
        edge = self.max_radius_px * (1.0 + 1e-12)
        return is_in_view(np.asarray(pixels, dtype=float), size, self.center_px, edge)

    def resized(self, width_px: int, height_px: int) -> RadiusTableCamera:
        """Return the camera at another image size: the same picture, as large as fits inside."""
        old, new = (self.width_px, self.height_px), (width_px, height_px)
        s, (u, v) = fit_inside(old, new, self.center_px)
        radii = tuple(s * R for R in self.radii_px)
        return replace(
            self, width_px=width_px, height_px=height_px, center_u_px=u, center_v_px=v,
            radii_px=radii,
        )  # fmt: skip

    @functools.cached_property
    def _curve(self) -> PchipInterpolator:
        """Theta over R, NaN outside."""
        angles = np.arctan2(self.distances_m, self.measured_height_m)
        return PchipInterpolator((0.0, *self.radii_px), (0.0, *angles), extrapolate=False)

    def _radius(self, angle: np.ndarray) -> np.ndarray:
        """Return R of theta; NaN outside the table."""
        knots, ends = self._curve.x, self._curve(self._curve.x)
        with np.errstate(invalid="ignore"):
            is_in = angle <= ends[-1] * (1.0 + 1e-12)
        target = np.where(is_in, np.minimum(angle, ends[-1]), np.nan)
        piece = np.clip(np.searchsorted(ends, target, side="right") - 1, 0, len(knots) - 2)
        curve = self._curve
        return solve_rising(
            curve, functools.partial(curve, nu=1), target, knots[piece], knots[piece + 1]
        )
