"""What no localizer of a team can do better: Cramer-Rao bounds, and identities by true poses."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from experiments.team_layouts import POSTS
from experiments.team_views_sim import Scene
from multi_localizer.team_views import NOBODY

GATE_SD = 3.5


def bearing_gradients(pose: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of the bearings to places (K, 2).

    Returns:
        By the pose that looks (x, y, yaw), (K, 3), and by the place looked at, (K, 2).
    """
    dx, dy = (places - pose[:2]).T
    by_place = np.column_stack((-dy, dx)) / (dx * dx + dy * dy)[:, None]
    return np.column_stack((-by_place, -np.ones(len(places)))), by_place


def information(scene: Scene, *, counts_rough: bool) -> np.ndarray:
    """Return the Fisher information of all poses at their true values, (3 N, 3 N).

    Counted: the real bearings with their true identities, the posts seen, and rough poses if they
    are independent of these bearings.
    """
    rows = [_rows(scene, index) for index in range(len(scene.layout.poses))]
    J = np.concatenate(rows) / scene.senses.noise
    fisher = J.T @ J
    for index, view in enumerate(scene.views):
        if counts_rough and view.rough is not None:
            own = slice(3 * index, 3 * index + 3)
            fisher[own, own] += np.linalg.inv(view.rough.cov)
    return fisher


def _rows(scene: Scene, index: int) -> np.ndarray:
    """Return the derivatives of what one robot sees by all poses, (M, 3 N)."""
    poses, ids = scene.layout.poses, scene.true_ids[index]
    others = ids[ids != NOBODY]
    kinds = scene.views[index].landmark_bearings
    places = np.concatenate([poses[others, :2], *(POSTS[kind] for kind in kinds)])
    by_pose, by_place = bearing_gradients(poses[index], places)
    J = np.zeros((len(places), 3 * len(poses)))
    J[:, 3 * index : 3 * index + 3] = by_pose
    k = np.arange(len(others))
    J[k, 3 * others], J[k, 3 * others + 1] = by_place[: len(others)].T
    return J


def bound(scene: Scene, *, counts_rough: bool) -> np.ndarray | None:
    """Return the least variance of each robot's x, y and yaw, (N, 3); None where unobservable."""
    fisher = information(scene, counts_rough=counts_rough)
    if np.linalg.matrix_rank(fisher) < len(fisher):
        return None
    return np.diag(np.linalg.inv(fisher)).reshape(-1, 3)


def oracle_ids(scene: Scene) -> tuple[np.ndarray, ...]:
    """Return the identities by true poses and by who can be seen: bearings that fit best in sum."""
    found = []
    for index, view in enumerate(scene.views):
        pose = scene.layout.poses[index]
        candidates = np.flatnonzero(scene.visible[index])
        dx, dy = (scene.layout.poses[candidates, :2] - pose[:2]).T
        off = view.bearings[:, None] - (np.arctan2(dy, dx) - pose[2])
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        cost = np.minimum((off / scene.senses.noise) ** 2, GATE_SD**2)
        ids = np.full(len(view.bearings), NOBODY)
        rows, columns = linear_sum_assignment(cost)
        is_near = cost[rows, columns] < GATE_SD**2
        ids[rows[is_near]] = candidates[columns[is_near]]
        found.append(ids)
    return tuple(found)
