"""How unsure a pose is that was followed for long: errors add up from node to node.

A scan is fitted to a map that earlier poses made, so its match says where it is in that map and
nothing of how wrong the map is. The covariance of a node is therefore that of the node before,
carried along the motion between them, and the motion's own (Smith and Cheeseman 1990, compounding):

    C_n = A C_k A^T + KEPT_SHARE E,   A = d T_n / d T_k, errors of both in their own axes,

where E is the covariance of the pose graph's edge. Only a share of it stays: scans in a row are
fitted to the same map, so what one motion errs by the next takes back. A pose behind the node has
the whole E of the motion from there. So C grows with the way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.key_frames import chain_cov
from grid_mapper.match_verdict import ScanResult
from grid_mapper.motion import rotated

KEPT_SHARE = 0.05
"""Share of the variance of a motion between nodes, no unit: by how much that of a long way grows
for each. Fitted to floor 7400:0.3 of `evaluate.py slam`, its slip and its laser."""


class Drift:
    """Gives the poses of scans covariances that hold all error since the beginning."""

    def __init__(self) -> None:
        self._node: tuple[SE2, np.ndarray] | None = None

    def restart(self) -> None:
        """Begin anew: the next pose that is trusted is as sure as its scan and prior say."""
        self._node = None

    def of(self, result: ScanResult, is_node: bool, config: GridMapperConfig) -> ScanResult:
        """Return a result with its covariance since the beginning.

        Args:
            result: With the covariance in what was seen lately.
            is_node: Whether the graph gets a node there.
            config: Says how far odometry and motions can be trusted.
        """
        pose = result.T_map_base
        own, before = rotated(result.cov, -pose.yaw), np.zeros((3, 3))
        if self._node is not None:
            T_node, cov_node = self._node
            before = carried(cov_node, T_node.between(pose))
            if result.is_trusted and result.information is not None:
                drift = config.loop.drift_m, config.loop.drift_rad
                own = chain_cov(T_node, pose, result.information, config.motion, drift)
        if is_node:
            kept = own if self._node is None else before + KEPT_SHARE * own
            self._node = pose, kept
        return replace(result, cov=rotated(before + own, pose.yaw))


def carried(cov: np.ndarray, moved: SE2) -> np.ndarray:
    """Return what the covariance of a pose is at the end of a motion that is known exactly.

    Args:
        cov: Of (x, y, yaw) in the axes of the pose, shape (3, 3).
        moved: The motion.

    Returns:
        The same in the axes of the end, shape (3, 3).
    """
    lever = np.array([[1.0, 0.0, -moved.y], [0.0, 1.0, moved.x], [0.0, 0.0, 1.0]])
    return rotated(lever @ cov @ lever.T, -moved.yaw)
