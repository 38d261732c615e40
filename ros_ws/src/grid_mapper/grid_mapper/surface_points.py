"""Scan points with the covariance of the surface patch each lies on (Segal et al. 2009, GICP).

A point measured on a wall says much about the distance to that wall and nothing about where along
it the beam ended. The covariance says so: thin across the surface, wide along it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.se2 import SE2

MAX_NEIGHBOURS = 4  # beams looked at on each side
MIN_PATCH_M = 0.1  # a patch reaches at least this far from its point
PATCH_BEAMS = 6.0  # and at least this many beam spacings


@dataclass(frozen=True)
class SurfacePoints:
    """Points and their covariances in one frame.

    Attributes:
        points: Shape (N, 2), m, in beam order.
        covs: Rows (xx, xy, yy), shape (N, 3), m^2.
    """

    points: np.ndarray
    covs: np.ndarray

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, T_a_b: SE2) -> SurfacePoints:
        """Return the points of frame b in frame a."""
        return SurfacePoints(T_a_b @ self.points, _rotate_covs(self.covs, T_a_b.yaw))


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
        spread: Deviation given along the surface, and to points without a patch, m.

    Returns:
        The points with covariances, in the same frame.

    Raises:
        ValueError: If points is not (N, 2).
    """
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {points.shape}")
    points = np.ascontiguousarray(points, np.float64)
    covs = _patch_covs(points, np.asarray(origin, np.float64), abs(angle_increment), sigma, spread)
    return SurfacePoints(points, covs)


@numba.njit(cache=True)
def _patch_covs(points, origin, angle_increment, sigma, spread):  # type: ignore[no-untyped-def]
    covs = np.empty((len(points), 3))
    for i in range(len(points)):
        distance = np.hypot(points[i, 0] - origin[0], points[i, 1] - origin[1])
        reach = max(MIN_PATCH_M, PATCH_BEAMS * angle_increment * distance)
        sx = sy = sxx = sxy = syy = 0.0
        n = 1
        for side in (-1, 1):
            for k in range(1, MAX_NEIGHBOURS + 1):
                j = i + side * k
                if j < 0 or j >= len(points):
                    break
                dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
                if dx * dx + dy * dy > reach * reach:
                    break
                sx, sy, n = sx + dx, sy + dy, n + 1
                sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
        if n < 3:
            covs[i, 0], covs[i, 1], covs[i, 2] = spread * spread, 0.0, spread * spread
            continue
        cxx, cxy, cyy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
        angle = 0.5 * np.arctan2(2.0 * cxy, cxx - cyy)  # of the long axis
        c, s = np.cos(angle), np.sin(angle)
        across = max(0.0, s * s * cxx - 2.0 * s * c * cxy + c * c * cyy) / n + sigma * sigma
        along = max(spread * spread, across)
        covs[i, 0] = c * c * along + s * s * across
        covs[i, 1] = c * s * (along - across)
        covs[i, 2] = s * s * along + c * c * across
    return covs


@numba.njit(cache=True)
def _rotate_covs(covs, yaw):  # type: ignore[no-untyped-def]
    c, s = np.cos(yaw), np.sin(yaw)
    out = np.empty_like(covs)
    for i in range(len(covs)):
        xx, xy, yy = covs[i, 0], covs[i, 1], covs[i, 2]
        out[i, 0] = c * c * xx - 2.0 * c * s * xy + s * s * yy
        out[i, 1] = c * s * (xx - yy) + (c * c - s * s) * xy
        out[i, 2] = s * s * xx + 2.0 * c * s * xy + c * c * yy
    return out
