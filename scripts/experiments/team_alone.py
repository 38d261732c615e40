"""The same robots alone, on the same bearings to the goal posts: where a team starts from.

Both are method 1 of the paper (2.3). `circles` is the published construction: the place nearest to
the circles of all pairs of posts. `least_squares` is the place on the field at which the bearings
are most likely. The first is told here that it is on the field, too: places beyond are drawn to its
border.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.team_bounds import bearing_gradients
from experiments.team_layouts import FIELD_X, FIELD_Y, POSTS
from experiments.team_views_sim import Scene
from floornav_common.se2 import SE2
from multi_localizer.landmark_circle import circle_fix
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_views import RobotView, TeamSolution

LEAST_POSTS = 3
_STEP_M = 0.2
_ROUNDS = 20
_STILL = 1e-6


def circles(scene: Scene) -> TeamSolution:
    """Return the poses of the robots that see three posts or more: circles, as published."""
    return _solution(scene, {view.name: _by_circles(view) for view in scene.views})


def least_squares(scene: Scene) -> TeamSolution:
    """Return the most likely poses of the robots that see three posts or more."""
    return _solution(scene, {view.name: _most_likely(view) for view in scene.views})


def with_own_poses(scene: Scene) -> Scene:
    """Return the scene with each robot's rough pose by least squares on the very same bearings."""
    estimates = least_squares(scene).estimates
    views = tuple(
        replace(view, rough=estimates.get(view.name), rough_from_landmarks=True)
        for view in scene.views
    )
    return replace(scene, views=views)


def _posts(view: RobotView) -> tuple[np.ndarray, np.ndarray]:
    """Return places (K, 2) and bearings (K,) of the posts seen."""
    kinds = list(view.landmark_bearings)
    places = np.concatenate([np.empty((0, 2)), *(POSTS[kind] for kind in kinds)])
    return places, np.array([view.landmark_bearings[kind][0] for kind in kinds])


def _by_circles(view: RobotView) -> SE2 | None:
    places, bearings = _posts(view)
    if len(places) < LEAST_POSTS:
        return None
    pose = circle_fix(places, bearings)
    if pose is None:
        return None
    place = np.clip((pose.x, pose.y), *_corners())
    return SE2(*place, _yaw_at(place, places, bearings))


def _most_likely(view: RobotView) -> SE2 | None:
    """Search the field in steps of 0.2 m, then descend (Gauss-Newton)."""
    places, bearings = _posts(view)
    if len(places) < LEAST_POSTS:
        return None
    start = _GRID[_costs(_GRID, places, bearings).argmin()]
    pose = np.array([*start, _yaw_at(start, places, bearings)])
    for _ in range(_ROUNDS):
        J, _ = bearing_gradients(pose, places)
        off = _wrapped(np.arctan2(*(places - pose[:2]).T[::-1]) - pose[2] - bearings)
        step = np.linalg.solve(J.T @ J + 1e-9 * np.eye(3), -J.T @ off)
        pose = pose + step
        if np.abs(step).max() < _STILL:
            break
    low, high = _corners()
    if np.any(pose[:2] < low) or np.any(pose[:2] > high):
        return SE2(*start, _yaw_at(start, places, bearings))
    return SE2(*pose)


def _yaw_at(place: np.ndarray, places: np.ndarray, bearings: np.ndarray) -> float:
    """Return the yaw that suits a spot best, rad."""
    off = np.arctan2(*(places - place).T[::-1]) - bearings
    return float(np.arctan2(np.sin(off).sum(), np.cos(off).sum()))


def _costs(spots: np.ndarray, places: np.ndarray, bearings: np.ndarray) -> np.ndarray:
    """Return the sum of squared bearing errors at each spot, with the yaw that suits it, (S,)."""
    off, yaws = _offsets(spots, places, bearings)
    return np.square(_wrapped(off - yaws[:, None])).sum(axis=1)


def _offsets(
    spots: np.ndarray, places: np.ndarray, bearings: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the yaw by each bearing at each spot, (S, K), and their mean, (S,)."""
    to_posts = places - spots[:, None]
    off = np.arctan2(to_posts[..., 1], to_posts[..., 0]) - bearings
    return off, np.arctan2(np.sin(off).sum(axis=1), np.cos(off).sum(axis=1))


def _wrapped(angles: np.ndarray) -> np.ndarray:
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def _corners() -> tuple[np.ndarray, np.ndarray]:
    half = np.array([0.5 * FIELD_X, 0.5 * FIELD_Y])
    return -half, half


def _grid() -> np.ndarray:
    low, high = _corners()
    x, y = (np.arange(a + 0.5 * _STEP_M, b, _STEP_M) for a, b in zip(low, high, strict=True))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _solution(scene: Scene, found: dict[str, SE2 | None]) -> TeamSolution:
    estimates = {
        view.name: PoseEstimate(pose, _covariance(pose, *_posts(view), scene.senses.noise))
        for view in scene.views
        if (pose := found[view.name]) is not None
    }
    return TeamSolution(names=scene.layout.names, estimates=estimates)


def _covariance(pose: SE2, places: np.ndarray, bearings: np.ndarray, noise: float) -> np.ndarray:
    """Return the covariance about a pose of all spots of the field, as likely as they are.

    From some places the posts look almost alike from the other end of the field: then it is large.
    """
    costs = _costs(_GRID, places, bearings) / noise**2
    weights = np.exp(-0.5 * (costs - costs.min()))
    _, yaws = _offsets(_GRID, places, bearings)
    off = np.column_stack((_GRID - (pose.x, pose.y), _wrapped(yaws - pose.yaw)))
    cov = (weights[:, None] * off).T @ off / weights.sum()
    return np.asarray(cov + np.diag(np.square((0.5 * _STEP_M, 0.5 * _STEP_M, noise))))


_GRID = _grid()
