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
FINAL_TOLERANCE, QUICK_TOLERANCE = 1e-5, 1e-3
"""Quick is enough on the way, where each solution is the start of the next."""
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


class GraphSolver:
    """Solves a graph that grows; what gtsam makes of an edge is kept for the next time."""

    def __init__(self) -> None:
        self._factors: dict[tuple[int, float], tuple[Edge, Any]] = {}

    def solve(
        self, poses: Sequence[SE2], edges: Sequence[Edge], kernel: float,
        tolerance: float = FINAL_TOLERANCE, is_free: np.ndarray | None = None,
    ) -> list[SE2]:  # fmt: skip
        """Return the poses that fit the edges best; the first node stays where it is.

        The kernel begins wide and is narrowed (graduated non-convexity, Blake and Zisserman 1987):
        a true loop that takes out much drift is far off at first, and must not count as false for
        that.

        Args:
            poses: Where to begin, by node.
            edges: The measured motions.
            kernel: Deviations at which a loop counts half, at last.
            tolerance: A step that lessens the error by a smaller share is the last.
            is_free: Which nodes the edges are of; others stay where they are, shape (N,), bool.
        """
        numbers = range(len(poses)) if is_free is None else np.flatnonzero(is_free).tolist()
        loops = [edge for edge in edges if edge.is_loop]
        worst = float(deviations_of(loops, poses).max(initial=0.0))
        widths = KERNEL_WIDTHS if worst > FAR_DEVIATIONS else KERNEL_WIDTHS[-1:]
        for width in widths:
            poses = self._solve(poses, numbers, edges, width * kernel, tolerance)
        kept = {(id(edge), width * kernel * edge.is_loop) for edge in edges for width in widths}
        self._factors = {key: self._factors[key] for key in self._factors if key in kept}
        return list(poses)

    def _solve(
        self, poses: Sequence[SE2], numbers: Sequence[int], edges: Sequence[Edge], kernel: float,
        tolerance: float,
    ) -> list[SE2]:  # fmt: skip
        gtsam = load_solver()
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        held = gtsam.noiseModel.Isotropic.Sigma(3, HELD_SIGMA)
        graph.add(gtsam.PriorFactorPose2(numbers[0], _pose2(gtsam, poses[numbers[0]]), held))
        for number in numbers:
            values.insert(number, _pose2(gtsam, poses[number]))
        for edge in edges:
            graph.add(self._factor(edge, kernel * edge.is_loop))
        params = gtsam.LevenbergMarquardtParams()
        params.setRelativeErrorTol(tolerance)
        result = gtsam.LevenbergMarquardtOptimizer(graph, values, params).optimize()
        found = list(poses)
        rows = gtsam.utilities.extractPose2(result).tolist()
        for number, row in zip(numbers, rows, strict=True):
            found[number] = SE2(*row)
        return found

    def _factor(self, edge: Edge, kernel: float) -> Any:
        """Return an edge as gtsam has it; a kernel of 0 is none."""
        key = id(edge), kernel
        if key not in self._factors:
            gtsam = load_solver()
            noise = gtsam.noiseModel.Gaussian.Covariance(edge.cov)
            if kernel > 0.0:
                cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(kernel)
                noise = gtsam.noiseModel.Robust.Create(cauchy, noise)
            motion = _pose2(gtsam, edge.T_first_second)
            factor = gtsam.BetweenFactorPose2(edge.first, edge.second, motion, noise)
            self._factors[key] = edge, factor  # the edge too, so that its id stays its own
        return self._factors[key][1]


def solve(poses: Sequence[SE2], edges: Sequence[Edge], kernel: float) -> list[SE2]:
    """Return the poses that fit the edges of one graph best; see `GraphSolver.solve`."""
    return GraphSolver().solve(poses, edges, kernel)


def deviations_of(edges: Sequence[Edge], poses: Sequence[SE2]) -> np.ndarray:
    """Return how far the poses are from what each edge measured, in its deviations, shape (N,)."""
    if not edges:
        return np.zeros(0)
    rows = np.array([edge.row for edge in edges])
    at = np.array([(pose.x, pose.y, pose.yaw) for pose in poses])
    first, second = at[rows[:, 0].astype(int)], at[rows[:, 1].astype(int)]
    seen = _seen_from(first, second)
    off = _seen_from(rows[:, 2:5], seen)
    information = rows[:, 5:].reshape(-1, 3, 3)
    return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", off, information, off)))


def _seen_from(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return poses b seen from poses a, all rows (x, y, yaw)."""
    d, c, s = b - a, np.cos(a[:, 2]), np.sin(a[:, 2])
    yaw = np.pi - (np.pi - d[:, 2]) % (2.0 * np.pi)
    return np.column_stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], yaw))


def deviations(edge: Edge, poses: Sequence[SE2]) -> float:
    """Return how far the poses are from what an edge measured, in its deviations."""
    return float(deviations_of([edge], poses)[0])


def _pose2(gtsam: Any, pose: SE2) -> Any:
    return gtsam.Pose2(pose.x, pose.y, pose.yaw)
