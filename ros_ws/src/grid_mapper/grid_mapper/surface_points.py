"""Scan points with the covariance of the surface patch each lies on (Segal et al. 2009, GICP).

A point measured on a wall says much about the distance to that wall and nothing about where along
it the beam ended. The covariance says so: thin across the surface, wide along it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import ScanMatcherConfig

MAX_NEIGHBOURS = 4  # looked at on each side
STEP_M = 0.05  # neighbours are at least about this far apart: nearer ones only show the noise
STEP_BEAMS = 15.0  # and at most this many times the spacing of beams on a wall faced squarely
MAX_GAP_M = 5.0


@dataclass(frozen=True)
class SurfacePoints:
    """Points and their patches in one frame.

    Attributes:
        points: Shape (N, 2), m, in beam order.
        covs: Rows (xx, xy, yy), shape (N, 3), m^2.
        normals: Unit vectors across each patch, towards the sensor that saw it, shape (N, 2); 0
            for a point without a patch.
    """

    points: np.ndarray
    covs: np.ndarray
    normals: np.ndarray

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, T_a_b: SE2) -> SurfacePoints:
        """Return the points of frame b in frame a."""
        covs, normals = _rotated(self.covs, self.normals, T_a_b.yaw)
        return SurfacePoints(T_a_b @ self.points, covs, normals)

    def every(self, stride: int) -> SurfacePoints:
        """Return one point of every `stride`."""
        return SurfacePoints(self.points[::stride], self.covs[::stride], self.normals[::stride])


def surface_points(
    points: np.ndarray, origin: np.ndarray, angle_increment: float, sigma: float,
    spread: float,
) -> SurfacePoints:  # fmt: skip
    """Estimate the patch each point lies on from its neighbours in the scan.

    Args:
        points: Obstacle points in beam order, shape (N, 2), m.
        origin: Where the sensor is, in the same frame, shape (2,), m.
        angle_increment: Angle between beams, rad.
        sigma: Deviation of a point across its surface, m.
        spread: Deviation given along the surface, and at least to points without a patch, m.

    Returns:
        The points with their patches, in the same frame.

    Raises:
        ValueError: If points is not (N, 2).
    """
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {points.shape}")
    points = np.ascontiguousarray(points, np.float64)
    origin = np.asarray(origin, np.float64)
    covs, normals = _patches(points, origin, abs(angle_increment), sigma, spread)
    return SurfacePoints(points, covs, normals)


def points_of(scan: Scan, T_base_laser: SE2, matcher: ScanMatcherConfig) -> SurfacePoints:
    """Return the points of a scan in the base frame, as they are matched."""
    points = surface_points(
        scan.points(), np.zeros(2), scan.angle_step, matcher.range_sigma_m,
        0.5 * matcher.cell_m,
    )  # fmt: skip
    return points.moved(T_base_laser)


@numba.njit(cache=True)
def _patches(points, origin, angle_increment, sigma, spread):  # type: ignore[no-untyped-def]
    covs = np.empty((len(points), 3))
    normals = np.zeros((len(points), 2))
    for i in range(len(points)):
        spacing = angle_increment * np.hypot(points[i, 0] - origin[0], points[i, 1] - origin[1])
        stride = max(1, int(STEP_M / max(spacing, 1e-6)))
        reach = max(2.0 * STEP_M, STEP_BEAMS * spacing)
        sx = sy = sxx = sxy = syy = 0.0
        n = 1
        for side in (-1, 1):
            for k in range(1, MAX_NEIGHBOURS + 1):
                j = i + side * k * stride
                if j < 0 or j >= len(points):
                    break
                dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
                if dx * dx + dy * dy > (k * reach) ** 2:
                    break
                sx, sy, n = sx + dx, sy + dy, n + 1
                sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
        if n < 3:
            # Such points sample a surface at steps of the gap: that is how well they repeat.
            gap = _gap(points, i)
            covs[i, 0] = covs[i, 2] = max(spread, gap) ** 2
            covs[i, 1] = 0.0
            continue
        cxx, cxy, cyy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
        angle = 0.5 * np.arctan2(2.0 * cxy, cxx - cyy)  # of the long axis
        c, s = np.cos(angle), np.sin(angle)
        across = max(0.0, s * s * cxx - 2.0 * s * c * cxy + c * c * cyy) / n + sigma * sigma
        along = max(spread * spread, across)
        covs[i, 0] = c * c * along + s * s * across
        covs[i, 1] = c * s * (along - across)
        covs[i, 2] = s * s * along + c * c * across
        towards = s * (points[i, 0] - origin[0]) - c * (points[i, 1] - origin[1])
        facing = 1.0 if towards > 0.0 else -1.0
        normals[i, 0], normals[i, 1] = -facing * s, facing * c
    return covs, normals


@numba.njit(cache=True)
def _gap(points, i):  # type: ignore[no-untyped-def]
    """Return the distance to the nearer of the two points beside point i, at most MAX_GAP_M."""
    gap = MAX_GAP_M
    for j in (i - 1, i + 1):
        if 0 <= j < len(points):
            gap = min(gap, np.hypot(points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]))
    return gap


@numba.njit(cache=True)
def _rotated(covs, normals, yaw):  # type: ignore[no-untyped-def]
    c, s = np.cos(yaw), np.sin(yaw)
    turned, across = np.empty_like(covs), np.empty_like(normals)
    for i in range(len(covs)):
        xx, xy, yy = covs[i, 0], covs[i, 1], covs[i, 2]
        turned[i, 0] = c * c * xx - 2.0 * c * s * xy + s * s * yy
        turned[i, 1] = c * s * (xx - yy) + (c * c - s * s) * xy
        turned[i, 2] = s * s * xx + 2.0 * c * s * xy + c * c * yy
        across[i, 0] = c * normals[i, 0] - s * normals[i, 1]
        across[i, 1] = s * normals[i, 0] + c * normals[i, 1]
    return turned, across
