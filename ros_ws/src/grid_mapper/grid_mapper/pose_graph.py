"""The pose graph: nodes tied by measured motions, solved with gtsam (Dellaert and Kaess 2017).

Loops carry a Cauchy kernel, so that a false one that slipped through pulls the less the further it
is off; the chain of motions carries none.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge

HELD_SIGMA = 1e-6
KERNEL_WIDTHS = (256.0, 16.0, 1.0)
FAR_DEVIATIONS = 5.0
"""Only where a loop is further off than this is the kernel begun wide."""
MISSING = (
    "loop closing needs the package gtsam, which is not installed: "
    "install it (requirements-robot.txt), or set loop_closing to false"
)


def load_solver() -> Any:
    """Return gtsam, imported when it is first needed.

    Raises:
        ValueError: If it is not installed.
    """
    try:
        return importlib.import_module("gtsam")
    except ImportError as error:
        raise ValueError(MISSING) from error


def solve(poses: Sequence[SE2], edges: Sequence[Edge], kernel: float) -> list[SE2]:
    """Return the poses that fit the edges best; the first node stays where it is.

    The kernel begins wide and is narrowed (graduated non-convexity, Blake and Zisserman 1987): a
    true loop that takes out much drift is far off at first, and must not count as false for that.

    Args:
        poses: Where to begin, by node.
        edges: The measured motions.
        kernel: Deviations at which a loop counts half, at last.
    """
    worst = max((deviations(edge, poses) for edge in edges if edge.is_loop), default=0.0)
    for width in KERNEL_WIDTHS if worst > FAR_DEVIATIONS else KERNEL_WIDTHS[-1:]:
        poses = _solve(poses, edges, width * kernel)
    return list(poses)


def _solve(poses: Sequence[SE2], edges: Sequence[Edge], kernel: float) -> list[SE2]:
    gtsam = load_solver()
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    held = gtsam.noiseModel.Isotropic.Sigma(3, HELD_SIGMA)
    graph.add(gtsam.PriorFactorPose2(0, _pose2(gtsam, poses[0]), held))
    for number, pose in enumerate(poses):
        values.insert(number, _pose2(gtsam, pose))
    cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(kernel)
    for edge in edges:
        noise = gtsam.noiseModel.Gaussian.Covariance(edge.cov)
        if edge.is_loop:
            noise = gtsam.noiseModel.Robust.Create(cauchy, noise)
        motion = _pose2(gtsam, edge.T_first_second)
        graph.add(gtsam.BetweenFactorPose2(edge.first, edge.second, motion, noise))
    result = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    found = (result.atPose2(number) for number in range(len(poses)))
    return [SE2(pose.x(), pose.y(), pose.theta()) for pose in found]


def deviations(edge: Edge, poses: Sequence[SE2]) -> float:
    """Return how far the poses are from what an edge measured, in its deviations."""
    off = edge.T_first_second.between(poses[edge.first].between(poses[edge.second])).as_array()
    return float(np.sqrt(off @ np.linalg.solve(edge.cov, off)))


def _pose2(gtsam: Any, pose: SE2) -> Any:
    return gtsam.Pose2(pose.x, pose.y, pose.yaw)
