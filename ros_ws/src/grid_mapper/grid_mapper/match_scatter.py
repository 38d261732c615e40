"""How far parts of a scan disagree on where in a map it was taken: what has moved since pulls.

The information of a match counts noise alone. Furniture that was shifted fits the map a little
aside, and along a wall nothing but it may say where the robot is; then most of the pairs fit, the
next look is pulled alike, and only what has stayed speaks against it.
"""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.scan_matcher import ScanMatcher, offset
from grid_mapper.surface_points import SurfacePoints

NUM_SECTORS = 8
"""As many parts of a scan, of as many points each, are left out in turn."""


def scatter_of(
    matcher: ScanMatcher, points: SurfacePoints, T_map_base: SE2, start_cov: np.ndarray
) -> np.ndarray:
    """Return the covariance of a fit by the jackknife over sectors (Efron and Stein 1981).

    (n - 1) / n sum_k (T_k - mean T)(T_k - mean T)^T, where T_k is the fit without sector k. A
    direction that only one sector tells stays where it was without it, and adds nothing: this is
    disagreement, beside the covariance of the match and not instead of it.

    Args:
        matcher: Holds the map.
        points: Of the scan, in the robot's frame.
        T_map_base: Where all of them fit.
        start_cov: How far a fit may go from there, shape (3, 3).

    Returns:
        Of (x, y, yaw) in map axes, shape (3, 3).
    """
    bearings = np.arctan2(points.points[:, 1], points.points[:, 0])
    order = np.argsort(bearings, kind="stable")
    fits = [
        matcher.match(_without(points, sector), T_map_base, start_cov).T_map_base
        for sector in np.array_split(order, NUM_SECTORS)
    ]
    off = np.array([offset(T_map_base, fit) for fit in fits])
    off -= off.mean(axis=0)
    return np.asarray((NUM_SECTORS - 1) / NUM_SECTORS * off.T @ off)


def _without(points: SurfacePoints, left_out: np.ndarray) -> SurfacePoints:
    kept = np.ones(len(points), bool)
    kept[left_out] = False
    return SurfacePoints(points.points[kept], points.covs[kept], points.normals[kept])
