"""A pose with its covariance in the map frame: what every localizer hands out, and its arithmetic.

Errors are `(x, y, yaw)` of the estimate less the truth, in the axes of the map, yaw wrapped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2, wrap_angle


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """Where a robot is, and how well that is known.

    Attributes:
        pose: Of base_link in the map frame.
        cov: Covariance of x, y, yaw in the map frame, (3, 3); symmetric, positive definite.
    """

    pose: SE2
    cov: np.ndarray

    def __post_init__(self) -> None:
        cov = np.array(self.cov, dtype=float)
        fault = _fault(cov.tolist()) if cov.shape == (3, 3) else "cov must be (3, 3)"
        if fault:
            raise ValueError(f"{fault}, got {cov.tolist()}")
        cov = 0.5 * (cov + cov.T)
        cov.flags.writeable = False
        object.__setattr__(self, "cov", cov)


def _fault(rows: list[list[float]]) -> str:
    """Return what is wrong with a covariance of three rows; "" if nothing."""
    if not all(math.isfinite(value) for row in rows for value in row):
        return "cov must be finite"
    for k, n in ((0, 1), (0, 2), (1, 2)):
        one, other = rows[k][n], rows[n][k]
        if abs(one - other) > 1e-6 * min(abs(one), abs(other)) + 1e-12:
            return "cov must be symmetric"
    return "" if _is_positive(*rows) else "cov must be positive definite"


def _is_positive(first: list[float], second: list[float], third: list[float]) -> bool:
    """Return whether a symmetric matrix of these rows is positive definite (Cholesky's pivots)."""
    a, (_, b, _), (_, _, c) = first[0], second, third
    if a <= 0.0:
        return False
    b -= first[1] * first[1] / a
    if b <= 0.0:
        return False
    off = second[2] - first[1] * first[2] / a
    return c - first[2] * first[2] / a - off * off / b > 0.0


def difference(a: SE2, b: SE2) -> np.ndarray:
    """Return `a` less `b` in the axes of the map: (dx, dy, dyaw), yaw in (-pi, pi]."""
    return np.array([a.x - b.x, a.y - b.y, wrap_angle(a.yaw - b.yaw)])


def fuse(a: PoseEstimate, b: PoseEstimate) -> PoseEstimate:
    """Return the estimate that two independent ones make together."""
    gain = a.cov @ np.linalg.inv(a.cov + b.cov)
    x, y, yaw = gain @ difference(b.pose, a.pose)
    keep = np.eye(3) - gain
    cov = keep @ a.cov @ keep.T + gain @ b.cov @ gain.T  # Joseph's form stays symmetric
    return PoseEstimate(SE2(a.pose.x + x, a.pose.y + y, a.pose.yaw + yaw), cov)


def mahalanobis(a: PoseEstimate, b: PoseEstimate) -> float:
    """Return the squared distance of two independent estimates: chi-squared with 3 degrees."""
    return normalized_error(a.pose, b.pose, a.cov + b.cov)


def normalized_error(pose: SE2, truth: SE2, cov: np.ndarray) -> float:
    """Return e^T C^-1 e of an error (NEES); its mean is 3 if the covariance is true."""
    e = difference(pose, truth)
    return float(e @ np.linalg.solve(cov, e))


def propagate(estimate: PoseEstimate, motion: SE2, motion_cov: np.ndarray) -> PoseEstimate:
    """Return the estimate after a motion.

    Args:
        estimate: Before it.
        motion: The robot's new pose seen from its old one.
        motion_cov: Covariance of the motion's x, y, yaw in the axes of the old pose, (3, 3).
    """
    c, s = np.cos(estimate.pose.yaw), np.sin(estimate.pose.yaw)
    by_pose = np.array([
        [1.0, 0.0, -s * motion.x - c * motion.y],
        [0.0, 1.0, c * motion.x - s * motion.y],
        [0.0, 0.0, 1.0],
    ])  # fmt: skip
    by_motion = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    cov = by_pose @ estimate.cov @ by_pose.T + by_motion @ motion_cov @ by_motion.T
    return PoseEstimate(estimate.pose @ motion, cov)


def moved(estimate: PoseEstimate, T_body_base: SE2) -> PoseEstimate:
    """Return the pose of another frame of the same body, such as base_link for the camera's."""
    return propagate(estimate, T_body_base, np.zeros((3, 3)))


def placed(T_new_map: SE2, estimate: PoseEstimate) -> PoseEstimate:
    """Return an estimate in other axes of the map; its covariance turns with them."""
    c, s = np.cos(T_new_map.yaw), np.sin(T_new_map.yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return PoseEstimate(T_new_map @ estimate.pose, turn @ estimate.cov @ turn.T)
