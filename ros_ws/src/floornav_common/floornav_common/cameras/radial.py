"""Images that are drawn by one curve: radius R over the angle theta from the optical axis.

In the image's frame (x right, y down, z where the center looks) a point q = (x, y), z is seen at
R(theta) q / |q|, theta = atan2(|q|, z).
"""

from __future__ import annotations

import numpy as np


def axis_angle(points: np.ndarray) -> np.ndarray:
    """Return theta of points (..., 3) in the image's frame, rad."""
    return np.arctan2(np.hypot(points[..., 0], points[..., 1]), points[..., 2])


def rays_at(offsets: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return unit vectors (..., 3) from offsets (..., 2) from the center and their theta."""
    R = np.hypot(offsets[..., 0], offsets[..., 1])
    flat = np.sin(angle) / np.where(R > 0.0, R, 1.0)
    return np.concatenate((offsets * flat[..., None], np.cos(angle)[..., None]), axis=-1)


def offsets_at(points: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return the offsets (..., 2) from the center at which points (..., 3) are seen at R."""
    q = points[..., :2]
    rho = np.hypot(q[..., 0], q[..., 1])
    return np.asarray(q * (radius / np.where(rho > 0.0, rho, 1.0))[..., None])


def offsets_jacobian(points: np.ndarray, radius: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return d(offsets)/d(x, y, z), shape (..., 2, 3).

    With s = R / |q| and n the distance: dR = R' (z dq.q/|q| - |q| dz) / n^2, so that
    d(s q) = s dq + (R' z / n^2 - s) q (q.dq) / |q|^2 - (R' / n^2) q dz.

    Args:
        points: Shape (..., 3), in the image's frame.
        radius: R at these points, shape (...).
        slope: dR/d(theta) there.
    """
    q, z = points[..., :2], points[..., 2]
    rho = np.hypot(q[..., 0], q[..., 1])
    n2 = rho**2 + z**2
    on_axis = rho < 1e-12 * np.abs(z)
    safe = np.where(on_axis, 1.0, rho)
    s = np.where(on_axis, slope / np.where(z == 0.0, 1.0, np.abs(z)), radius / safe)
    along = np.where(on_axis, 0.0, (slope * z / n2 - s) / safe**2)
    flat = s[..., None, None] * np.eye(2) + along[..., None, None] * (
        q[..., :, None] * q[..., None, :]
    )
    return np.concatenate((flat, -(slope / n2)[..., None, None] * q[..., :, None]), axis=-1)
