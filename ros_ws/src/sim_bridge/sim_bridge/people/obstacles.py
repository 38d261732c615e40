"""Solids as people meet them: how near they are, and what they hide from sight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_bridge.solids import Solid

_EYE_HEIGHT = 1.5
_BODY_HEIGHT = 1.7


class Obstacles:
    """Footprints of a world's solids, all at once.

    Args:
        solids: The scenery; what hangs above people's heads is left out.
    """

    def __init__(self, solids: Sequence[Solid]) -> None:
        near = [s for s in solids if s.bottom < _BODY_HEIGHT and s.size[2] + s.bottom > 0.1]
        self._middle = np.array([[s.pose.x, s.pose.y] for s in near]).reshape(-1, 2)
        yaw = np.array([s.pose.yaw for s in near])
        self._c, self._s = np.cos(yaw), np.sin(yaw)
        self._half = np.array([s.size[:2] for s in near]).reshape(-1, 2) / 2.0
        self._is_round = np.array([s.is_round for s in near], dtype=bool)
        self._hides = np.array([_hides(s) for s in near], dtype=bool)

    def away(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distance from each solid to each point and the way off it.

        Args:
            points: Shape (N, 2), m.

        Returns:
            Distances (N, S), 0 inside; unit vectors (N, S, 2) from the solid to the point.
        """
        local = self._local(points)
        nearest = np.clip(local, -self._half, self._half)
        radius = self._half[:, 0]
        length = np.maximum(np.linalg.norm(local, axis=2), 1e-9)
        on_circle = local * np.minimum(1.0, radius / length)[..., None]
        nearest = np.where(self._is_round[:, None], on_circle, nearest)
        off = local - nearest
        distance = np.linalg.norm(off, axis=2)
        # Inside there is no way off but away from the middle.
        off = np.where(distance[..., None] > 1e-9, off, local)
        unit = off / np.maximum(np.linalg.norm(off, axis=2), 1e-9)[..., None]
        c, s = self._c, self._s
        turned = (c * unit[..., 0] - s * unit[..., 1], s * unit[..., 0] + c * unit[..., 1])
        return distance, np.stack(turned, axis=2)

    def is_hidden(self, eye: np.ndarray, point: np.ndarray) -> bool:
        """Tell whether something that reaches eye height stands between two points, (2,) each."""
        if not self._hides.any():
            return False
        start, end = self._local(np.stack((eye, point)))[:, self._hides]
        way, half = end - start, self._half[self._hides]
        length2 = np.maximum((way**2).sum(axis=1), 1e-12)
        share = np.clip(-(start * way).sum(axis=1) / length2, 0.0, 1.0)
        is_in_circle = np.linalg.norm(start + share[:, None] * way, axis=1) < half[:, 0]
        safe = np.where(np.abs(way) < 1e-9, 1e-9, way)
        cuts = np.stack(((-half - start) / safe, (half - start) / safe))
        enters, leaves = cuts.min(axis=0).max(axis=1), cuts.max(axis=0).min(axis=1)
        is_in_box = (enters < leaves) & (leaves > 0.0) & (enters < 1.0)
        return bool(np.where(self._is_round[self._hides], is_in_circle, is_in_box).any())

    def _local(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 2) in the frame of each solid, (N, S, 2)."""
        off = points[:, None, :] - self._middle
        x, y = off[..., 0], off[..., 1]
        return np.stack((self._c * x + self._s * y, self._c * y - self._s * x), axis=2)


def _hides(solid: Solid) -> bool:
    return solid.glass is None and solid.bottom < _EYE_HEIGHT < solid.bottom + solid.size[2]
