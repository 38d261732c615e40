"""The unified central model (Geyer and Daniilidis 2000; Mei and Rives 2007): mirrors and fisheyes.

A point is put on the unit sphere and seen from xi above its center (n its distance):

    m = (x, y) / (z + xi n),   rho^2 = |m|^2
    m_d = m (1 + k1 rho^2 + k2 rho^4) + (2 p1 x y + p2 (rho^2 + 2 x^2), ...)   [radial-tangential]
    u = fx m_dx + skew m_dy + cx,   v = fy m_dy + cy

xi = 1 is a parabolic mirror, 0 a pinhole, between them a hyperbolic mirror. The figures are those
of OpenCV's `omnidir`, kalibr's `omni-radtan` and camodocal's `MEI`. z points where the image's
center looks, so down for a camera below a mirror (`looks: mirror_above`).
"""

from __future__ import annotations

import functools
import math
from dataclasses import MISSING, dataclass, replace

import numpy as np

from floornav_common.cameras.central import LOOKS, fit_inside, is_in_view, optical_axes
from floornav_common.cameras.rising import solve_rising
from floornav_common.cameras.sphere import (
    distort,
    distort_jacobian,
    flatten,
    flatten_jacobian,
    lift,
)
from floornav_common.config import param, validate

KIND = "unified"
_MAX_STEPS = 20
_TOL = 1e-13


@dataclass(frozen=True, kw_only=True)
class UnifiedCamera:
    """One camera of this kind at one image size."""

    width_px: int = param(MISSING, "Columns of the image.", unit="px", gt=0)
    height_px: int = param(MISSING, "Rows of the image.", unit="px", gt=0)
    xi: float = param(MISSING, "How far above the sphere's center it is seen from.", ge=0.0)
    fx_px: float = param(MISSING, "Focal length along the rows.", unit="px", gt=0.0)
    fy_px: float = param(MISSING, "Focal length along the columns.", unit="px", gt=0.0)
    center_u_px: float = param(MISSING, "Column of the optical axis (cx).", unit="px")
    center_v_px: float = param(MISSING, "Row of the optical axis (cy).", unit="px")
    skew_px: float = param(0.0, "Skew of the pixel axes.", unit="px")
    k1: float = param(0.0, "Radial distortion, rho^2.")
    k2: float = param(0.0, "Radial distortion, rho^4.")
    p1: float = param(0.0, "Tangential distortion.")
    p2: float = param(0.0, "Tangential distortion.")
    max_radius_px: float = param(0.0, "Edge of the view; 0: none.", unit="px", ge=0.0)
    looks: str = param("mirror_above", "Where the camera looks.", choices=LOOKS)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def center_px(self) -> tuple[float, float]:
        """Pixel (u, v) of the optical axis."""
        return self.center_u_px, self.center_v_px

    @property
    def is_symmetric(self) -> bool:
        """Whether the image is the same in all directions around an upright axis."""
        is_round = self.fx_px == self.fy_px and self.skew_px == self.p1 == self.p2 == 0.0
        return is_round and self.looks != "forward"

    @property
    def pixel_matrix(self) -> np.ndarray:
        """The linear part of the step from m_d to pixels, (2, 2)."""
        return np.array([[self.fx_px, self.skew_px], [0.0, self.fy_px]])

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors (..., 3) of pixels (..., 2); NaN where the model has none."""
        flat = (np.asarray(pixels, dtype=float) - self.center_px) @ np.linalg.inv(
            self.pixel_matrix
        ).T
        return np.asarray(lift(self._undistorted(flat), self.xi) @ optical_axes(self.looks).T)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) of points (..., 3) at the viewpoint; NaN where not seen."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        plane = flatten(turned, self.xi)
        rho = np.hypot(plane[..., 0], plane[..., 1])
        with np.errstate(invalid="ignore"):
            is_seen = rho <= self._max_rho
        bent = distort(plane, (self.k1, self.k2, self.p1, self.p2))
        pixels = np.where(is_seen[..., None], bent, np.nan) @ self.pixel_matrix.T + self.center_px
        return np.where(self._is_in_view(pixels)[..., None], pixels, np.nan)

    def project_jacobian(self, points: np.ndarray) -> np.ndarray:
        """Return d(u, v)/d(x, y, z) at points (..., 3), shape (..., 2, 3)."""
        turned = np.asarray(points) @ optical_axes(self.looks)
        bend = distort_jacobian(flatten(turned, self.xi), (self.k1, self.k2, self.p1, self.p2))
        by_point = flatten_jacobian(turned, self.xi) @ optical_axes(self.looks).T
        return np.asarray(self.pixel_matrix @ bend @ by_point)

    def sees(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether pixels (..., 2) are in the image, within its edge, and have a ray."""
        pixels = np.asarray(pixels, dtype=float)
        return np.asarray(self._is_in_view(pixels) & np.isfinite(self.rays(pixels)[..., 0]))

    def resized(self, width_px: int, height_px: int) -> UnifiedCamera:
        """Return the camera at another image size: the same picture, as large as fits inside."""
        old, new = (self.width_px, self.height_px), (width_px, height_px)
        s, (u, v) = fit_inside(old, new, self.center_px)
        return replace(
            self, width_px=width_px, height_px=height_px, fx_px=s * self.fx_px,
            fy_px=s * self.fy_px, skew_px=s * self.skew_px, center_u_px=u, center_v_px=v,
            max_radius_px=s * self.max_radius_px,
        )  # fmt: skip

    def _is_in_view(self, pixels: np.ndarray) -> np.ndarray:
        size = self.width_px, self.height_px
        edge = self.max_radius_px if self.max_radius_px > 0.0 else math.inf
        return is_in_view(pixels, size, self.center_px, edge)

    @functools.cached_property
    def _max_rho(self) -> float:
        """Largest rho with a ray that the distortion does not fold back."""
        sphere = (self.xi**2 - 1.0) ** -0.5 if self.xi > 1.0 else math.inf
        turns = np.roots((5.0 * self.k2, 3.0 * self.k1, 1.0))  # of d(rho_d)/d(rho), in rho^2
        folds = [float(t.real) for t in turns if abs(t.imag) < 1e-12 and t.real > 0.0]
        return min(sphere, math.sqrt(min(folds, default=math.inf)))

    def _undistorted(self, bent: np.ndarray) -> np.ndarray:
        """Return m of m_d: the radial part along its direction, then Newton steps for the rest."""
        k = self.k1, self.k2, self.p1, self.p2
        plane = bent
        if any(k):
            rho_d = np.hypot(bent[..., 0], bent[..., 1])
            rho = self._unbent(rho_d)
            plane = (
                bent
                * np.where(rho_d > 0.0, rho / np.where(rho_d > 0.0, rho_d, 1.0), 1.0)[..., None]
            )
            for _ in range(_MAX_STEPS if self.p1 or self.p2 else 0):
                off = distort(plane, k) - bent
                plane = plane - np.linalg.solve(distort_jacobian(plane, k), off[..., None])[..., 0]
                if not np.nanmax(np.abs(off), initial=0.0) > _TOL:
                    break
        with np.errstate(invalid="ignore"):
            is_seen = np.hypot(plane[..., 0], plane[..., 1]) <= self._max_rho * (1.0 + 1e-12)
        return np.where(is_seen[..., None], plane, np.nan)

    def _unbent(self, rho_d: np.ndarray) -> np.ndarray:
        """Return rho of a rho_d that only k1 and k2 made; NaN beyond the fold."""

        def bent(rho: np.ndarray) -> np.ndarray:
            return np.asarray(rho * (1.0 + rho**2 * (self.k1 + self.k2 * rho**2)))

        def slope(rho: np.ndarray) -> np.ndarray:
            return np.asarray(1.0 + rho**2 * (3.0 * self.k1 + 5.0 * self.k2 * rho**2))

        most = float(np.nanmax(rho_d, initial=0.0))
        end = min(self._max_rho, max(1.0, most))
        while end < self._max_rho and bent(np.array(end)) < most:
            end = min(2.0 * end, self._max_rho)
        last = float(bent(np.array(end)))
        with np.errstate(invalid="ignore"):
            target = np.where(rho_d <= last * (1.0 + 1e-12), np.minimum(rho_d, last), np.nan)
        return solve_rising(bent, slope, target, np.zeros(()), np.array(end))
