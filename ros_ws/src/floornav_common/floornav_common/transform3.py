"""Rigid motions in space, as TF carries them; rotations by scipy, composition by numpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from floornav_common.se2 import SE2


@dataclass(frozen=True, slots=True, eq=False)
class Transform3:
    """A rigid transform: `T_a_b` takes coordinates of frame b to frame a.

    Attributes:
        matrix_4x4: Homogeneous matrix, shape (4, 4), m; not to be written to.
    """

    matrix_4x4: np.ndarray

    @staticmethod
    def identity() -> Transform3:
        """Return the transform that moves nothing."""
        return Transform3(np.eye(4))

    @staticmethod
    def from_parts(translation: Sequence[float], quat_xyzw: Sequence[float]) -> Transform3:
        """Build from a translation (x, y, z), m, and a quaternion (x, y, z, w) that is not 0."""
        rotation = Rotation.from_quat(np.asarray(quat_xyzw, dtype=float))
        return Transform3(homogeneous(rotation.as_matrix(), np.asarray(translation, dtype=float)))

    @staticmethod
    def from_se2(pose: SE2) -> Transform3:
        """Lift a planar transform: z, roll and pitch are 0."""
        matrix = np.eye(4)
        c, s = np.cos(pose.yaw), np.sin(pose.yaw)
        matrix[:2, :2] = ((c, -s), (s, c))
        matrix[:2, 3] = pose.x, pose.y
        return Transform3(matrix)

    def matrix(self) -> np.ndarray:
        """Return the homogeneous matrix, shape (4, 4)."""
        return self.matrix_4x4

    @property
    def translation(self) -> np.ndarray:
        """Origin of frame b in frame a, shape (3,), m."""
        return self.matrix_4x4[:3, 3]

    @property
    def rotation(self) -> np.ndarray:
        """Rotation matrix, shape (3, 3)."""
        return self.matrix_4x4[:3, :3]

    @property
    def quat_xyzw(self) -> np.ndarray:
        """Unit quaternion (x, y, z, w) with w >= 0, shape (4,)."""
        quat: np.ndarray = Rotation.from_matrix(self.rotation).as_quat()
        return -quat if quat[3] < 0.0 else quat

    @property
    def is_upside_down(self) -> bool:
        """Whether the z axis of frame b points down in frame a, as of a laser hung from above.

        The planar part cannot say so: beams of such a scanner run clockwise seen from above.
        """
        return bool(self.matrix_4x4[2, 2] < 0.0)

    def to_se2(self) -> SE2:
        """Return the planar part: x, y and the heading of frame b's x axis in frame a's plane."""
        m = self.matrix_4x4
        return SE2(float(m[0, 3]), float(m[1, 3]), float(np.arctan2(m[1, 0], m[0, 0])))

    def __matmul__(self, other: Transform3) -> Transform3:
        """Compose: `T_a_c = T_a_b @ T_b_c`."""
        return Transform3(self.matrix_4x4 @ other.matrix_4x4)

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Return points of frame b in frame a; shape (N, 3), rows are points."""
        moved: np.ndarray = points @ self.rotation.T + self.translation
        return moved

    def inverse(self) -> Transform3:
        """Return the transform that undoes this one."""
        return Transform3(invert(self.matrix_4x4))


def homogeneous(rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
    """Return the (4, 4) matrix of a rotation (3, 3) and a translation (3,)."""
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = rotation
    matrix[:3, 3] = translation
    matrix[3, 3] = 1.0
    return matrix


def invert(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse of a rigid (4, 4) matrix."""
    turned_back = matrix[:3, :3].T
    return homogeneous(turned_back, -(turned_back @ matrix[:3, 3]))
