"""Where a unified camera sees a flat board, and how that depends on camera and pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floor_perception.board_pose import posed, posed_jacobian
from floornav_common.cameras.sphere import distort, distort_jacobian, flatten, flatten_jacobian

INTRINSICS = (
    "xi", "fx_px", "fy_px", "center_u_px", "center_v_px", "skew_px", "k1", "k2", "p1", "p2",
)  # fmt: skip


@dataclass(frozen=True)
class BoardView:
    """One picture of a board.

    Attributes:
        points_board: Corners on the board, shape (N, 2), in the board's unit.
        pixels: Where they are in the picture, shape (N, 2).
    """

    points_board: np.ndarray
    pixels: np.ndarray


def view_pixels(intrinsics: np.ndarray, pose: np.ndarray, points_board: np.ndarray) -> np.ndarray:
    """Return the pixels (N, 2) of a board's points (N, 2) in a pose, in the image's frame."""
    plane = flatten(posed(pose, points_board), intrinsics[0])
    bent = distort(plane, tuple(intrinsics[6:10]))
    return np.asarray(bent @ _pixel_matrix(intrinsics).T + intrinsics[3:5])


def view_jacobian(
    intrinsics: np.ndarray, pose: np.ndarray, points_board: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return d(pixels)/d(intrinsics), (N, 2, 10), and d(pixels)/d(pose), (N, 2, 6)."""
    points, k = posed(pose, points_board), tuple(intrinsics[6:10])
    plane, matrix = flatten(points, intrinsics[0]), _pixel_matrix(intrinsics)
    bend = matrix @ distort_jacobian(plane, k)
    n = np.linalg.norm(points, axis=-1)
    x, y = plane.T
    rho2 = x**2 + y**2
    bent = distort(plane, k)
    by = np.zeros((len(points), 2, len(INTRINSICS)))
    w = points[:, 2] + intrinsics[0] * n
    by[:, :, 0] = np.einsum("nij,nj->ni", bend, -plane * (n / w)[:, None])  # d(q / w)/d(xi)
    by[:, 0, 1], by[:, 1, 2], by[:, 0, 5] = bent[:, 0], bent[:, 1], bent[:, 1]
    by[:, 0, 3] = by[:, 1, 4] = 1.0
    by_k = (
        plane * rho2[:, None], plane * rho2[:, None] ** 2,
        np.stack((2.0 * x * y, rho2 + 2.0 * y**2), -1),
        np.stack((rho2 + 2.0 * x**2, 2.0 * x * y), -1),
    )  # fmt: skip
    by[:, :, 6:] = np.stack([column @ matrix.T for column in by_k], axis=-1)
    by_point = bend @ flatten_jacobian(points, intrinsics[0])
    return by, by_point @ posed_jacobian(pose, points_board)


def _pixel_matrix(intrinsics: np.ndarray) -> np.ndarray:
    return np.array([[intrinsics[1], intrinsics[5]], [0.0, intrinsics[2]]])
