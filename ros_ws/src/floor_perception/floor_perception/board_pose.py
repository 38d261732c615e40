"""Where a flat board stands: a first guess from rays, and the motion of its points."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def board_pose(points_board: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return the pose of a board from the rays to its points, by the linear method.

    Each ray b is along H (X, Y, 1), H = s [r1 r2 t]: b x H p = 0, solved by SVD; the sign is the
    one that has the points along the rays and not against them.

    Args:
        points_board: Shape (N, 2), N >= 4.
        rays: Unit vectors, shape (N, 3).

    Returns:
        Rotation vector and translation, shape (6,).
    """
    middle, scale = points_board.mean(axis=0), max(float(np.ptp(points_board)), 1e-12)
    flat = (points_board - middle) / scale
    p = np.concatenate((flat, np.ones((len(flat), 1))), axis=1)
    rows = np.einsum("nij,nk->nijk", _cross(rays), p).reshape(-1, 9)
    H = np.linalg.svd(np.nan_to_num(rows))[2][-1].reshape(3, 3)
    H = H * np.sign(np.einsum("ni,ij,nj->n", np.nan_to_num(rays), H, p).sum())
    H = H / np.sqrt(np.linalg.norm(H[:, 0]) * np.linalg.norm(H[:, 1]))
    u, _, v = np.linalg.svd(np.column_stack((H[:, 0], H[:, 1], np.cross(H[:, 0], H[:, 1]))))
    R = u @ np.diag((1.0, 1.0, np.linalg.det(u @ v))) @ v
    t = scale * H[:, 2] - R[:, :2] @ middle
    return np.concatenate((Rotation.from_matrix(R).as_rotvec(), t))


def posed(pose: np.ndarray, points_board: np.ndarray) -> np.ndarray:
    """Return a board's points (N, 2) in a pose, shape (N, 3)."""
    R = Rotation.from_rotvec(pose[:3]).as_matrix()
    return np.asarray(points_board @ R[:, :2].T + pose[3:])


def posed_jacobian(pose: np.ndarray, points_board: np.ndarray) -> np.ndarray:
    """Return d(posed)/d(pose), shape (N, 3, 6).

    d(exp(w) X)/dw = -exp(w) [X]x Jr(w), Jr = I - (1 - cos a)/a^2 [w]x + (a - sin a)/a^3 [w]x^2.
    """
    w = pose[:3]
    a = float(np.linalg.norm(w))
    first, second = 0.5, 1.0 / 6.0
    if a > 1e-4:
        first, second = (1.0 - np.cos(a)) / a**2, (a - np.sin(a)) / a**3
    W = _cross(w)
    right = np.eye(3) - first * W + second * W @ W
    R = Rotation.from_rotvec(w).as_matrix()
    points = np.concatenate((points_board, np.zeros((len(points_board), 1))), axis=1)
    by_turn = -R @ _cross(points) @ right
    by_shift = np.broadcast_to(np.eye(3), by_turn.shape)
    return np.concatenate((by_turn, by_shift), axis=-1)


def _cross(v: np.ndarray) -> np.ndarray:
    """Return [v]x of vectors (..., 3), shape (..., 3, 3)."""
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return matrix - np.swapaxes(matrix, -1, -2)
