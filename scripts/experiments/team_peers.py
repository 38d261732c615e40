"""What the team's solver is held against: other solvers for given identities, and every triangle.

Kato et al. (1999) checked all combinations of angles of all triples of robots before they had a
result; `count_triangles` does that check and nothing more.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from experiments.team_layouts import POSTS
from experiments.team_views_sim import Scene
from multi_localizer.team_views import NOBODY
from multi_localizer.triangles import angles_between, count_sums


def starts(scene: Scene) -> np.ndarray:
    """Return the rough poses, (N, 3): where every solver begins."""
    return np.array([view.rough.pose.as_array() for view in scene.views if view.rough is not None])


def scipy_poses(scene: Scene) -> np.ndarray:
    """Return all poses, (N, 3), by `scipy.optimize.least_squares` with the analytic Jacobian."""
    problem = _Problem(scene)
    found = least_squares(
        problem.residuals, starts(scene).ravel(), jac=problem.jacobian, method="lm"
    )
    return found.x.reshape(-1, 3)


def gtsam_poses(scene: Scene) -> np.ndarray:
    """Return all poses, (N, 3), by gtsam's Levenberg-Marquardt, its graph built anew."""
    import gtsam

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    noise = gtsam.noiseModel.Isotropic.Sigma(1, scene.senses.noise)
    sure = gtsam.noiseModel.Isotropic.Sigma(2, 1e-4)
    posts = {kind: 1000 + k for k, kind in enumerate(POSTS)}
    for kind, key in posts.items():
        values.insert(key, gtsam.Point2(*POSTS[kind][0]))
        graph.add(gtsam.PriorFactorPoint2(key, gtsam.Point2(*POSTS[kind][0]), sure))
    for index, (view, ids) in enumerate(zip(scene.views, scene.true_ids, strict=True)):
        assert view.rough is not None
        pose = gtsam.Pose2(*view.rough.pose.as_array())
        values.insert(index, pose)
        rough = gtsam.noiseModel.Diagonal.Sigmas(np.sqrt(np.diag(view.rough.cov)))
        graph.add(gtsam.PriorFactorPose2(index, pose, rough))
        for bearing, other in zip(view.bearings, ids, strict=True):
            if other != NOBODY:
                graph.add(
                    gtsam.BearingFactorPose2(index, int(other), gtsam.Rot2(float(bearing)), noise)
                )
        for kind, bearings in view.landmark_bearings.items():
            seen = gtsam.Rot2(float(bearings[0]))
            graph.add(gtsam.BearingFactor2D(index, posts[kind], seen, noise))
    result = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    poses = (result.atPose2(k) for k in range(len(scene.views)))
    return np.array([(pose.x(), pose.y(), pose.theta()) for pose in poses])


class _Problem:
    """Residuals of bearings, posts and rough poses in deviations, with true identities."""

    def __init__(self, scene: Scene) -> None:
        rows: list[tuple[int, int, float]] = []  # who looks, at which robot, where
        marks: list[tuple[int, np.ndarray, float]] = []
        for index, (view, ids) in enumerate(zip(scene.views, scene.true_ids, strict=True)):
            rows += [(index, j, b) for j, b in zip(ids, view.bearings, strict=True) if j != NOBODY]
            marks += [(index, POSTS[k][0], b[0]) for k, b in view.landmark_bearings.items()]
        self._eye = np.array([r[0] for r in rows] + [m[0] for m in marks])
        self._robot = np.array([r[1] for r in rows])
        self._marks = np.array([m[1] for m in marks]).reshape(-1, 2)
        self._bearings = np.array([r[2] for r in rows] + [m[2] for m in marks])
        self._noise, self._rough = scene.senses.noise, starts(scene)
        self._rough_sd = np.array([np.sqrt(np.diag(v.rough.cov)) for v in scene.views if v.rough])

    def _ways(self, poses: np.ndarray) -> np.ndarray:
        return np.concatenate((poses[self._robot, :2], self._marks)) - poses[self._eye, :2]

    def residuals(self, x: np.ndarray) -> np.ndarray:
        poses = x.reshape(-1, 3)
        dx, dy = self._ways(poses).T
        off = np.arctan2(dy, dx) - poses[self._eye, 2] - self._bearings
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        prior = poses - self._rough
        prior[:, 2] = (prior[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
        return np.concatenate((off / self._noise, (prior / self._rough_sd).ravel()))

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        ways = self._ways(x.reshape(-1, 3))
        by_place = np.column_stack((-ways[:, 1], ways[:, 0])) / np.square(ways).sum(axis=1)[:, None]
        J = np.zeros((len(ways), len(x)))
        k = np.arange(len(ways))
        for axis in range(2):
            J[k, 3 * self._eye + axis] = -by_place[:, axis]
            to_robots = slice(len(self._robot))
            J[k[to_robots], 3 * self._robot + axis] = by_place[to_robots, axis]
        J[k, 3 * self._eye + 2] = -1.0
        return np.concatenate((J / self._noise, np.diag(1.0 / self._rough_sd.ravel())))


def count_triangles(scene: Scene, tolerance: float, most_triples: int | None = None) -> int:
    """Check the angles of all triples of robots against each other; return how many fit.

    Args:
        scene: What was seen.
        tolerance: Of the sum of three angles, rad (dE).
        most_triples: Check only so many triples; None for all.
    """
    angles = [angles_between(view.bearings) for view in scene.views]
    start = np.cumsum([0, *(len(a) for a in angles)])
    limit = np.iinfo(np.int64).max if most_triples is None else most_triples
    return int(count_sums(np.concatenate(angles), start, tolerance, limit))


def num_triples(num_robots: int) -> int:
    """Return how many triples of robots there are."""
    return num_robots * (num_robots - 1) * (num_robots - 2) // 6
