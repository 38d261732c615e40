"""Robots whose bearings are not explained are looked for anew, and rough poses that lie dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from multi_localizer.team_fit import TeamFit
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_relocate import (
    MOST_PRIOR,
    best_places,
    best_pose,
    crossing_score,
    nearest_table,
    pattern_score,
)
from multi_localizer.team_state import Identification
from multi_localizer.team_trust import WRONG_PRIOR

_ANYWHERE = 1.0  # m around the team
_REACH = 3.2  # deviations of a rough pose
_BETTER = 2.0  # log-likelihood that a new place must gain
_BETTER_ANYWHERE = 6.0
_BLUR = 0.04  # m
_LEAST_PLACED = 2
_LITTLE = 0.8  # share of its bearings: a robot that explains less may be anywhere
_SURE = 0.8
_PLACED_SD = 0.6  # m; robots known worse help nobody
_GRID_COV = np.diag(np.square((0.08, 0.08, 0.03)))


def explained_share(problem: TeamProblem, found: Identification) -> np.ndarray:
    """Return the share of each robot's bearings that are believed to be somebody's, (N,)."""
    counts = np.diff(problem.start)
    owners = np.repeat(np.arange(problem.num_robots), counts)
    explained = np.bincount(owners[found.belief > 0.6], minlength=problem.num_robots)
    return explained / np.maximum(counts, 1)


def returned_share(problem: TeamProblem, found: Identification) -> np.ndarray:
    """Return the share of each robot's bearings whose owner surely has one back, (N,)."""
    counts = np.diff(problem.start)
    owners = np.repeat(np.arange(problem.num_robots), counts)
    is_returned = returned(problem, found) >= 0
    num_returned = np.bincount(owners[is_returned], minlength=problem.num_robots)
    return num_returned / np.maximum(counts, 1)


def relocate_lost(
    problem: TeamProblem, found: Identification, lost: np.ndarray
) -> tuple[Identification, int]:
    """Look for robots anew.

    Args:
        problem: The views.
        found: Identities and poses so far.
        lost: Indices of the robots, in the order in which to look.

    Returns:
        found: With new poses of those that were found elsewhere, and without their identities.
        num_moved: How many.
    """
    x, cov = found.fit.poses.copy(), found.fit.cov.copy()
    owner = returned(problem, found)
    seen, weight, num_moved = found.seen.copy(), found.prior_weight.copy(), 0
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    is_lost = np.zeros(problem.num_robots, dtype=np.bool_)
    is_lost[lost] = True
    share = explained_share(problem, found)
    for u in lost:
        is_lost[u] = False
        is_open = (owner < 0) | (owner == u) | (owners == u)
        is_wide = weight[u] == 0.0 or share[u] < _LITTLE
        search = _Search(
            problem, x, cov, int(u), nearest_table(problem.start, problem.bearings, is_open),
            _placed(cov) & ~is_lost & (np.arange(len(x)) != u), bool(weight[u] > 0.0),
        )  # fmt: skip
        pose = search.better_pose(is_wide)
        if pose is None:
            continue
        num_moved += 1
        put(x, cov, int(u), pose)
        seen[(seen == u) | (owners == u)] = -1
        if weight[u] > 0.0 and prior_distance(problem, int(u), pose) > WRONG_PRIOR:
            weight[u] = 0.0
    fit = TeamFit(x, cov, found.fit.cost)
    return replace(found, fit=fit, seen=seen, prior_weight=weight), num_moved


def returned(problem: TeamProblem, found: Identification) -> np.ndarray:
    """Return the owners of bearings that are sure and that the owner returns, (M,); -1 else."""
    n = problem.num_robots
    owners = np.repeat(np.arange(n), np.diff(problem.start))
    is_sure = (found.belief > _SURE) & (found.owner >= 0)
    sees = np.zeros((n, n), dtype=np.bool_)
    sees[owners[is_sure], found.owner[is_sure]] = True
    result = np.full(len(owners), -1, dtype=np.int64)
    result[is_sure] = np.where(
        sees[found.owner[is_sure], owners[is_sure]], found.owner[is_sure], -1
    )
    return result


def _placed(cov: np.ndarray) -> np.ndarray:
    """Return which robots are known well enough to help, (N,) bool."""
    var = np.diag(cov).reshape(-1, 3)
    return np.asarray(0.5 * (var[:, 0] + var[:, 1]) < _PLACED_SD**2)


@dataclass(frozen=True, eq=False)
class _Search:
    """The search for one robot, `u`, among those that are placed."""

    problem: TeamProblem
    x: np.ndarray
    cov: np.ndarray
    u: int
    table: np.ndarray
    is_placed: np.ndarray
    has_prior: bool

    def better_pose(self, is_wide: bool) -> np.ndarray | None:
        """Return a pose that explains more than the present one, (3,); None if there is none."""
        if self.is_placed.sum() < _LEAST_PLACED:
            return None
        now = self.score(self.x[self.u]) if _placed(self.cov)[self.u] else -np.inf
        if self.has_prior:
            prior = self.problem.prior[self.u]
            sd = np.sqrt(np.diag(np.linalg.inv(self.problem.prior_info[self.u])))
            half = _REACH * np.maximum(sd[:2], 0.05)
            pose = self.look(prior, half, float(_REACH * sd[2]))
            if self.score(pose) > now + _BETTER:
                return pose
        if not is_wide:
            return None
        corners = np.vstack((self.x[self.is_placed, :2], self.problem.marks))
        low, high = corners.min(axis=0) - _ANYWHERE, corners.max(axis=0) + _ANYWHERE
        middle = np.array([*(0.5 * (low + high)), 0.0])
        pose = self.look(middle, 0.5 * (high - low), 2.0 * np.pi)
        return pose if self.score(pose) > now + _BETTER_ANYWHERE else None

    def look(self, middle: np.ndarray, half: np.ndarray, yaw_reach: float) -> np.ndarray:
        """Return the best pose around `middle`, (3,); rough poses speak within their reach."""
        problem = self.problem
        info = problem.prior_info[self.u] * (yaw_reach < np.pi)
        arrays = (self.x, self.cov, problem.bearings, problem.var, self.table, self.is_placed)
        places = best_places(
            self.u, middle[:2], half, problem.prior[self.u], info, *arrays
        )  # fmt: skip
        pose = best_pose(
            self.u, places, middle[2], yaw_reach, _BLUR, *arrays, *_mark_arrays(problem)
        )
        return np.asarray(pose[:3])

    def score(self, pose: np.ndarray) -> float:
        """Return how well a pose explains everybody's bearings, a log-likelihood."""
        problem = self.problem
        arrays = (self.x, self.cov, problem.bearings, problem.var, self.table, self.is_placed)
        px, py, yaw = (float(value) for value in pose)
        score = crossing_score(px, py, self.u, _BLUR, *arrays)
        score += pattern_score(px, py, yaw, self.u, _BLUR, *arrays, *_mark_arrays(problem))
        if self.has_prior:
            score -= min(0.5 * prior_distance(problem, self.u, pose), MOST_PRIOR)
        return float(score)


def _mark_arrays(problem: TeamProblem) -> tuple[np.ndarray, ...]:
    return (
        problem.mark_robot, problem.mark_bearing, problem.mark_var, problem.marks,
        problem.kind_start[problem.mark_kind], problem.kind_start[problem.mark_kind + 1],
    )  # fmt: skip


def prior_distance(problem: TeamProblem, u: int, pose: np.ndarray) -> float:
    """Return the squared deviations of a pose from the rough one."""
    e = pose - problem.prior[u]
    e[2] = (e[2] + np.pi) % (2.0 * np.pi) - np.pi
    return float(e @ problem.prior_info[u] @ e)


def put(
    x: np.ndarray, cov: np.ndarray, u: int, pose: np.ndarray, own: np.ndarray | None = None
) -> None:
    """Set robot u to a pose of covariance `own`; by default as well known as a search's grid."""
    x[u] = pose
    part = slice(3 * u, 3 * u + 3)
    cov[part, :] = 0.0
    cov[:, part] = 0.0
    cov[part, part] = _GRID_COV if own is None else own
