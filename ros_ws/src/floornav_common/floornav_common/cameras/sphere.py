"""The steps of the unified model as plain functions: sphere to plane, and radial-tangential bend.

Points are in the image's frame, z where the center looks; `m` is on the plane at distance 1.
"""

from __future__ import annotations

import numpy as np


def flatten(points: np.ndarray, xi: float) -> np.ndarray:
    """Return m = (x, y) / (z + xi n) of points (..., 3); NaN where xi above the sphere hides them.

    For xi < 1 what is seen lies above z = -xi n, for xi >= 1 above z = -n / xi.
    """
    n = np.linalg.norm(points, axis=-1)
    w = points[..., 2] + xi * n
    floor = xi if xi < 1.0 else 1.0 / xi
    with np.errstate(invalid="ignore"):
        is_seen = (points[..., 2] > -floor * n) & (w > 0.0)
    return np.asarray(points[..., :2] / np.where(is_seen, w, np.nan)[..., None])


def flatten_jacobian(points: np.ndarray, xi: float) -> np.ndarray:
    """Return dm/d(x, y, z), shape (..., 2, 3)."""
    n = np.linalg.norm(points, axis=-1)
    w = points[..., 2] + xi * n
    dw = xi * points / n[..., None]
    dw[..., 2] += 1.0
    eye = np.eye(2, 3)
    by_depth = points[..., :2, None] * dw[..., None, :]
    return np.asarray(eye / w[..., None, None] - by_depth / w[..., None, None] ** 2)


def lift(plane: np.ndarray, xi: float) -> np.ndarray:
    """Return the unit vectors (..., 3) of m (..., 2); the inverse of `flatten`, NaN without one."""
    rho2 = (plane**2).sum(axis=-1)
    with np.errstate(invalid="ignore"):
        factor = (xi + np.sqrt(1.0 + (1.0 - xi**2) * rho2)) / (rho2 + 1.0)
    return np.concatenate((factor[..., None] * plane, (factor - xi)[..., None]), axis=-1)


def distort(plane: np.ndarray, k: tuple[float, float, float, float]) -> np.ndarray:
    """Return m_d of m (..., 2); k holds k1, k2, p1, p2."""
    x, y = plane[..., 0], plane[..., 1]
    rho2 = x**2 + y**2
    radial = 1.0 + rho2 * (k[0] + k[1] * rho2)
    return np.stack(
        (
            x * radial + 2.0 * k[2] * x * y + k[3] * (rho2 + 2.0 * x**2),
            y * radial + 2.0 * k[3] * x * y + k[2] * (rho2 + 2.0 * y**2),
        ),
        axis=-1,
    )


def distort_jacobian(plane: np.ndarray, k: tuple[float, float, float, float]) -> np.ndarray:
    """Return dm_d/dm, shape (..., 2, 2)."""
    x, y = plane[..., 0], plane[..., 1]
    rho2 = x**2 + y**2
    radial, growth = 1.0 + rho2 * (k[0] + k[1] * rho2), 2.0 * k[0] + 4.0 * k[1] * rho2
    mixed = growth * x * y + 2.0 * (k[2] * x + k[3] * y)
    first = radial + growth * x**2 + 2.0 * k[2] * y + 6.0 * k[3] * x
    second = radial + growth * y**2 + 6.0 * k[2] * y + 2.0 * k[3] * x
    rows = (np.stack((first, mixed), -1), np.stack((mixed, second), -1))
    return np.stack(rows, axis=-2)
