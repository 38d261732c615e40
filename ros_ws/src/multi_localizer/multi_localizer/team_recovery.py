"""Robots whose bearings are not explained are looked for anew, and rough poses that lie dropped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_relocate import best_places, best_pose, crossing_score, pattern_score
from multi_localizer.team_state import Identification

_ANYWHERE = 1.0  # m around the team
_REACH = 3.2  # deviations of a rough pose
_BETTER = 2.0  # log-likelihood that a new place must gain
_BETTER_ANYWHERE = 6.0
_BLUR = 0.04  # m
_PLACED_SD = 0.6  # m; robots known worse help nobody
_WRONG_PRIOR = 20.0  # squared deviations of a rough pose from where the robot is: it was wrong


def explained_share(problem: TeamProblem, found: Identification) -> np.ndarray:
    """Return the share of each robot's bearings that are believed to be somebody's, (N,)."""
    counts = np.diff(problem.start)
    owners = np.repeat(np.arange(problem.num_robots), counts)
    explained = np.bincount(owners[found.belief > 0.6], minlength=problem.num_robots)
    return explained / np.maximum(counts, 1)


def relocate_lost(
    problem: TeamProblem, found: Identification, lost: np.ndarray, config: TeamConfig
) -> tuple[Identification, int]:
    """Look for robots anew.

    Args:
        problem: The views.
        found: Identities and poses so far.
        lost: Indices of the robots, in the order in which to look.
        config: Tuning.

    Returns:
        found: With new poses of those that were found elsewhere, and without their identities.
        num_moved: How many.
    """
    x, cov = found.fit.poses.copy(), found.fit.cov.copy()
    owner = np.where(found.belief > 0.8, found.owner, -1)
    seen, weight, num_moved = found.seen.copy(), found.prior_weight.copy(), 0
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    is_lost = np.zeros(problem.num_robots, dtype=np.bool_)
    is_lost[lost] = True
    for u in lost:
        pose = _search(problem, x, cov, owner, int(u), is_lost, weight, config)
        is_lost[u] = False
        if pose is None:
            continue
        num_moved += 1
        _put(x, cov, int(u), pose)
        seen[(seen == u) | (owners == u)] = -1
        if weight[u] > 0.0 and _prior_distance(problem, int(u), pose) > _WRONG_PRIOR:
            weight[u] = 0.0
    fit = TeamFit(x, cov, found.fit.cost)
    return replace(found, fit=fit, seen=seen, prior_weight=weight), num_moved


def _search(
    problem: TeamProblem, x: np.ndarray, cov: np.ndarray, owner: np.ndarray, u: int,
    is_lost: np.ndarray, weight: np.ndarray, config: TeamConfig,
) -> np.ndarray | None:  # fmt: skip
    """Return a better pose of robot u, (3,); None if there is none."""
    is_open = (owner < 0) | (owner == u)
    var = np.diag(cov).reshape(-1, 3)
    is_placed = np.sqrt(0.5 * (var[:, 0] + var[:, 1])) < _PLACED_SD
    is_placed &= ~is_lost
    is_placed[u] = False
    if is_placed.sum() < 2:
        return None
    now = -np.inf
    has_prior = weight[u] > 0.0
    if np.sqrt(var[u, 0]) < config.far_sd_m:
        now = _score(problem, x, cov, u, is_open, is_placed, x[u], has_prior)
    best = None
    if has_prior:
        sd = np.sqrt(np.diag(np.linalg.inv(problem.prior_info[u])))
        half = _REACH * np.maximum(sd[:2], 0.05)
        pose = _look(problem, x, cov, u, is_open, is_placed, problem.prior[u], half, _REACH * sd[2])
        score = _score(problem, x, cov, u, is_open, is_placed, pose, has_prior)
        if score > now + _BETTER:
            best, now = pose, score
    if best is None:
        corners = np.vstack((x[is_placed, :2], problem.marks))
        low, high = corners.min(axis=0) - _ANYWHERE, corners.max(axis=0) + _ANYWHERE
        middle = np.array([*(0.5 * (low + high)), 0.0])
        pose = _look(
            problem, x, cov, u, is_open, is_placed, middle, 0.5 * (high - low), 2.0 * np.pi
        )
        if _score(problem, x, cov, u, is_open, is_placed, pose, has_prior) > now + _BETTER_ANYWHERE:
            best = pose
    return best


def _look(
    problem: TeamProblem, x: np.ndarray, cov: np.ndarray, u: int, is_open: np.ndarray,
    is_placed: np.ndarray, middle: np.ndarray, half: np.ndarray, yaw_reach: float,
) -> np.ndarray:  # fmt: skip
    """Return the best pose around `middle`, (3,)."""
    info = problem.prior_info[u] * (yaw_reach < np.pi)
    places = best_places(
        u, middle[:2], half, problem.prior[u], info, x, cov, problem.start, problem.bearings,
        problem.var, is_open, is_placed,
    )  # fmt: skip
    pose = best_pose(
        u, places, middle[2], yaw_reach, _BLUR, x, cov, problem.start, problem.bearings,
        problem.var, is_placed, *_mark_arrays(problem),
    )  # fmt: skip
    return np.asarray(pose[:3])


def _score(
    problem: TeamProblem, x: np.ndarray, cov: np.ndarray, u: int, is_open: np.ndarray,
    is_placed: np.ndarray, pose: np.ndarray, has_prior: bool,
) -> float:  # fmt: skip
    arrays = (x, cov, problem.start, problem.bearings, problem.var)
    px, py, yaw = (float(value) for value in pose)
    score = crossing_score(px, py, u, _BLUR, *arrays, is_open, is_placed)
    score += pattern_score(px, py, yaw, u, _BLUR, *arrays, is_placed, *_mark_arrays(problem))
    if has_prior:
        score -= min(0.5 * _prior_distance(problem, u, pose), 8.0)
    return float(score)


def _mark_arrays(problem: TeamProblem) -> tuple[np.ndarray, ...]:
    return (
        problem.mark_robot, problem.mark_bearing, problem.mark_var, problem.marks,
        problem.kind_start[problem.mark_kind], problem.kind_start[problem.mark_kind + 1],
    )  # fmt: skip


def _prior_distance(problem: TeamProblem, u: int, pose: np.ndarray) -> float:
    """Return the squared deviations of a pose from the rough one."""
    e = pose - problem.prior[u]
    e[2] = (e[2] + np.pi) % (2.0 * np.pi) - np.pi
    return float(e @ problem.prior_info[u] @ e)


def _put(x: np.ndarray, cov: np.ndarray, u: int, pose: np.ndarray) -> None:
    """Set robot u to a pose found by the search, as well known as its grid."""
    x[u] = pose
    cov[3 * u : 3 * u + 3, :] = 0.0
    cov[:, 3 * u : 3 * u + 3] = 0.0
    for c, sd in enumerate((0.08, 0.08, 0.03)):
        cov[3 * u + c, 3 * u + c] = sd * sd
