"""Rigid motions in the plane and angles (REP 103: x forward, y left, yaw counter-clockwise)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np


def wrap_angle(angle: float) -> float:
    """Return the angle in (-pi, pi] that points the same way."""
    return float(np.pi - (np.pi - angle) % (2.0 * np.pi))


@dataclass(frozen=True, slots=True)
class SE2:
    """A pose or a transform in the plane.

    `T_a_b = SE2(...)` is frame b seen from frame a: `p_a = T_a_b @ p_b`, `T_a_c = T_a_b @ T_b_c`.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Radians; kept in (-pi, pi].
    """

    x: float
    y: float
    yaw: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.x) and np.isfinite(self.y) and np.isfinite(self.yaw)):
            raise ValueError(f"x, y and yaw must be finite, got ({self.x}, {self.y}, {self.yaw})")
        object.__setattr__(self, "yaw", wrap_angle(self.yaw))

    @staticmethod
    def identity() -> SE2:
        """Return the motion that moves nothing."""
        return SE2(0.0, 0.0, 0.0)

    @overload
    def __matmul__(self, other: SE2) -> SE2: ...
    @overload
    def __matmul__(self, other: np.ndarray) -> np.ndarray: ...
    def __matmul__(self, other: SE2 | np.ndarray) -> SE2 | np.ndarray:
        """Compose with a transform, or move points of shape (N, 2) (rows are points)."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        if isinstance(other, SE2):
            return SE2(
                float(self.x + c * other.x - s * other.y),
                float(self.y + s * other.x + c * other.y),
                self.yaw + other.yaw,
            )
        return other @ np.array([[c, s], [-s, c]]) + np.array([self.x, self.y])

    def inverse(self) -> SE2:
        """Return the transform that undoes this one."""
        c, s = float(np.cos(self.yaw)), float(np.sin(self.yaw))
        return SE2(-c * self.x - s * self.y, s * self.x - c * self.y, -self.yaw)

    def between(self, other: SE2) -> SE2:
        """Return `other` seen from this pose: `self.inverse() @ other`."""
        return self.inverse() @ other

    def interpolate(self, other: SE2, share: float) -> SE2:
        """Return the pose `share` (0..1) of the way to `other`: straight line, shorter turn."""
        turn = wrap_angle(other.yaw - self.yaw)
        return SE2(
            self.x + share * (other.x - self.x),
            self.y + share * (other.y - self.y),
            self.yaw + share * turn,
        )

    @property
    def distance(self) -> float:
        """Length of the translation, m."""
        return float(np.hypot(self.x, self.y))

    def as_array(self) -> np.ndarray:
        """Return `[x, y, yaw]`, shape (3,)."""
        return np.array([self.x, self.y, self.yaw])
