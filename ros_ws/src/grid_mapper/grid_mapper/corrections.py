"""What the solved graph says of poses that the front end has followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2

NO_NODE = -1


@dataclass(frozen=True)
class Corrections:
    """Where the nodes of the graph are in both frames.

    Attributes:
        local: Pose (x, y, yaw) of each node by the front end, shape (N, 3); its frame drifts and
            never jumps.
        solved: The same in the map, shape (N, 3).
    """

    local: np.ndarray
    solved: np.ndarray

    @staticmethod
    def of(local: Sequence[SE2], solved: Sequence[SE2]) -> Corrections:
        """Return the corrections of nodes given as poses."""
        return Corrections(_rows(local), _rows(solved))

    @property
    def T_map_local(self) -> SE2:  # noqa: N802, frames rule of the transforms
        """What moves poses of now into the map: the newest node's correction."""
        if not len(self.local):
            return SE2.identity()
        return _pose(self.solved[-1]) @ _pose(self.local[-1]).inverse()

    def at(self, node: int, T_local_base: SE2) -> SE2:
        """Return a pose in the map; see `all_at`."""
        return _pose(self.all_at(np.array([node]), T_local_base.as_array()[None])[0])

    @staticmethod
    def as_poses(rows: np.ndarray) -> list[SE2]:
        """Return rows (x, y, yaw), shape (M, 3), as poses."""
        return [SE2(*row) for row in rows.tolist()]

    def all_at(self, nodes: np.ndarray, local: np.ndarray) -> np.ndarray:
        """Return poses in the map: corrected as the nodes before and after them, by nearness.

        Args:
            nodes: The newest node when a pose was taken, shape (M,); `NO_NODE` before the first,
                and a node that is not known here counts as the last.
            local: The poses by the front end, shape (M, 3).

        Returns:
            Shape (M, 3).
        """
        last = len(self.local) - 1
        if last < 0:
            return local.copy()
        before = np.clip(nodes, 0, last)
        after = np.minimum(before + 1, last)
        first, second = (self._moved_on(k, local) for k in (before, after))
        gone, left = (_offset(self.local[k], local) for k in (before, after))
        share = np.where(before < after, gone / np.maximum(gone + left, 1e-12), 0.0)[:, None]
        found = first + share * np.column_stack(
            (second[:, :2] - first[:, :2], _wrapped(second[:, 2] - first[:, 2]))
        )
        return np.where((nodes == NO_NODE)[:, None], local, found)

    def _moved_on(self, nodes: np.ndarray, local: np.ndarray) -> np.ndarray:
        """Return where the front end's motion leads from nodes."""
        start, solved = self.local[nodes], self.solved[nodes]
        turn = solved[:, 2] - start[:, 2]
        c, s = np.cos(turn), np.sin(turn)
        dx, dy = (local[:, :2] - start[:, :2]).T
        x, y = solved[:, 0] + c * dx - s * dy, solved[:, 1] + s * dx + c * dy
        return np.column_stack((x, y, local[:, 2] + turn))


def _rows(poses: Sequence[SE2]) -> np.ndarray:
    return np.array([(p.x, p.y, p.yaw) for p in poses]).reshape(-1, 3)


def _pose(row: np.ndarray) -> SE2:
    return SE2(*row.tolist())


def _offset(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return how far poses are apart, m and rad counted alike, shape (M,)."""
    turn = _wrapped(b[:, 2] - a[:, 2])
    return np.sqrt((b[:, 0] - a[:, 0]) ** 2 + (b[:, 1] - a[:, 1]) ** 2 + turn**2)


def _wrapped(angles: np.ndarray) -> np.ndarray:
    return np.pi - (np.pi - angles) % (2.0 * np.pi)
