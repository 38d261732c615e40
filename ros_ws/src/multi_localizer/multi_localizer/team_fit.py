"""Poses of a team by nonlinear least squares over all bearings, landmarks and rough poses.

Levenberg-Marquardt on the normal equations of `team_normal`. A residual beyond `limit` deviations
counts ever less. Every pose also has a prior so weak (1 km, 100 rad) that it only keeps the
equations regular: what the data do not determine has a deviation that large, and is found by it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from multi_localizer.team_linear import cholesky, inverse_cholesky, solve_cholesky
from multi_localizer.team_normal import add_bearing, add_mark, add_prior, wrap
from multi_localizer.team_problem import TeamProblem

_WEAK = 1e-6  # 1 / m^2: a kilometer
_WEAK_YAW = 1e-4  # 1 / rad^2
_LONGEST = 3.0  # m and rad: one step of a fit that is not gone to its end
_STOP = 3e-4  # m and rad: a step as short ends the iteration


@dataclass(frozen=True, eq=False)
class TeamFit:
    """Poses with their covariance.

    Attributes:
        poses: (N, 3).
        cov: (3 N, 3 N).
        cost: Sum of squared residuals in deviations, as weighted.
    """

    poses: np.ndarray
    cov: np.ndarray
    cost: float


def fit_poses(
    problem: TeamProblem,
    poses: np.ndarray,
    seen: np.ndarray,
    mark_seen: np.ndarray,
    prior_weight: np.ndarray,
    limit: float = 4.0,
    max_steps: int = 30,
) -> TeamFit:
    """Fit all poses for given identities.

    Args:
        problem: The views.
        poses: Where to start, (N, 3).
        seen: Robot that each bearing belongs to, (M,); negative ones are left out.
        mark_seen: Row of `problem.marks` of each bearing to a landmark, (K,); likewise.
        prior_weight: What each rough pose counts, (N,), 0..1.
        limit: Deviations beyond which a residual counts less.
        max_steps: At most so many.
    """
    x, cov, cost = solve(
        poses, problem.start, problem.bearings, problem.var, seen,
        problem.mark_robot, problem.mark_bearing, problem.mark_var, problem.marks, mark_seen,
        problem.prior, problem.prior_info, prior_weight, limit, max_steps,
    )  # fmt: skip
    return TeamFit(x, cov, float(cost))


def step_poses(
    problem: TeamProblem, poses: np.ndarray, seen: np.ndarray, mark_seen: np.ndarray,
    prior_weight: np.ndarray, limit: float,
) -> TeamFit:  # fmt: skip
    """Go one step of Gauss and Newton towards the fit; arguments as in `fit_poses`.

    It is no longer than a few meters. The covariance is that of the poses it started from.
    """
    x, cov, cost = step(
        poses, problem.start, problem.bearings, problem.var, seen,
        problem.mark_robot, problem.mark_bearing, problem.mark_var, problem.marks, mark_seen,
        problem.prior, problem.prior_info, prior_weight, limit,
    )  # fmt: skip
    return TeamFit(x, cov, float(cost))


@numba.njit(cache=True)
def step(
    poses: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray, seen: np.ndarray,
    mark_robot: np.ndarray, mark_bearing: np.ndarray, mark_var: np.ndarray, marks: np.ndarray,
    mark_seen: np.ndarray, prior: np.ndarray, prior_info: np.ndarray, prior_weight: np.ndarray,
    limit: float,
) -> tuple[np.ndarray, np.ndarray, float]:  # fmt: skip
    """Return poses a step on, covariance and cost before it; arguments as in `solve`."""
    size = 3 * len(poses)
    H, L, g = np.zeros((size, size)), np.zeros((size, size)), np.zeros(size)
    cost = normal_equations(
        H, g, poses, start, bearings, var, seen, mark_robot, mark_bearing, mark_var, marks,
        mark_seen, prior, prior_info, prior_weight, limit,
    )  # fmt: skip
    cov = inverse(H, L)
    way = np.minimum(np.maximum(solve_cholesky(L, -g), -_LONGEST), _LONGEST)
    return moved(poses, way), cov, cost


@numba.njit(cache=True)
def solve(
    poses: np.ndarray, start: np.ndarray, bearings: np.ndarray, var: np.ndarray, seen: np.ndarray,
    mark_robot: np.ndarray, mark_bearing: np.ndarray, mark_var: np.ndarray, marks: np.ndarray,
    mark_seen: np.ndarray, prior: np.ndarray, prior_info: np.ndarray, prior_weight: np.ndarray,
    limit: float, max_steps: int,
) -> tuple[np.ndarray, np.ndarray, float]:  # fmt: skip
    """Return poses, covariance and cost; arguments as in `fit_poses`, arrays of `TeamProblem`."""
    x = poses.copy()
    size = 3 * len(x)
    H, L, damped = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    g, damping = np.zeros(size), 1e-6
    cost = normal_equations(
        H, g, x, start, bearings, var, seen, mark_robot, mark_bearing, mark_var, marks, mark_seen,
        prior, prior_info, prior_weight, limit,
    )  # fmt: skip
    next_H, next_g = np.zeros((size, size)), np.zeros(size)
    for _ in range(max_steps):
        damped[:] = H + damping * np.diag(np.diag(H))
        if not cholesky(damped, L):
            damping = max(10.0 * damping, 1e-4)
            continue
        step = solve_cholesky(L, -g)
        tried = moved(x, step)
        next_cost = normal_equations(
            next_H, next_g, tried, start, bearings, var, seen, mark_robot, mark_bearing, mark_var,
            marks, mark_seen, prior, prior_info, prior_weight, limit,
        )  # fmt: skip
        is_small = np.max(np.abs(step)) < _STOP
        if next_cost <= cost + 1e-9:
            x, cost, damping = tried, next_cost, damping * 0.1
            H, next_H, g, next_g = next_H, H, next_g, g
        else:
            damping = max(10.0 * damping, 1e-4)
        if is_small or damping > 1e8:
            break
    return x, inverse(H, L), cost


@numba.njit(cache=True)
def inverse(H: np.ndarray, L: np.ndarray) -> np.ndarray:
    """Return the inverse of H, a little more on its diagonal if need be; L becomes its factor."""
    raised = H.copy()
    while not cholesky(raised, L):
        for k in range(len(H)):
            raised[k, k] *= 1.0 + 1e-9
    return inverse_cholesky(L)


@numba.njit(cache=True)
def solve_each(
    poses: np.ndarray, mark_start: np.ndarray, mark_bearing: np.ndarray, mark_var: np.ndarray,
    marks: np.ndarray, mark_seen: np.ndarray, prior: np.ndarray, prior_info: np.ndarray,
    prior_weight: np.ndarray, limit: float, max_steps: int,
) -> tuple[np.ndarray, np.ndarray, float]:  # fmt: skip
    """Return what `solve` does where no robot sees another: each robot is fitted by itself.

    The bearings to landmarks of robot i are `mark_start[i]:mark_start[i + 1]`.
    """
    n, cost = len(poses), 0.0
    x, cov = poses.copy(), np.zeros((3 * n, 3 * n))
    nothing, nobody = np.zeros(0), np.zeros(0, dtype=np.int64)
    for i in range(n):
        a, b, own = mark_start[i], mark_start[i + 1], slice(i, i + 1)
        one, its_cov, its_cost = solve(
            poses[own], np.zeros(2, dtype=np.int64), nothing, nothing, nobody,
            np.zeros(b - a, dtype=np.int64), mark_bearing[a:b], mark_var[a:b], marks,
            mark_seen[a:b], prior[own], prior_info[own], prior_weight[own], limit, max_steps,
        )  # fmt: skip
        x[i], cost = one[0], cost + its_cost
        cov[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = its_cov
    return x, cov, cost


@numba.njit(cache=True)
def moved(x: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return poses after a step of all their coordinates, no robot by more than half a turn."""
    result = x.copy()
    for i in range(len(x)):
        for c in range(2):
            result[i, c] += step[3 * i + c]
        result[i, 2] = wrap(x[i, 2] + min(max(step[3 * i + 2], -1.0), 1.0))
    return result


@numba.njit(cache=True)
def normal_equations(
    H: np.ndarray, g: np.ndarray, x: np.ndarray, start: np.ndarray, bearings: np.ndarray,
    var: np.ndarray, seen: np.ndarray, mark_robot: np.ndarray, mark_bearing: np.ndarray,
    mark_var: np.ndarray, marks: np.ndarray, mark_seen: np.ndarray, prior: np.ndarray,
    prior_info: np.ndarray, prior_weight: np.ndarray, limit: float,
) -> float:  # fmt: skip
    """Write H (its lower half) and g of H dx = -g at x; return the cost."""
    H[:] = 0.0
    g[:] = 0.0
    cost = 0.0
    for i in range(len(x)):
        H[3 * i, 3 * i] += _WEAK
        H[3 * i + 1, 3 * i + 1] += _WEAK
        H[3 * i + 2, 3 * i + 2] += _WEAK_YAW
        if prior_weight[i] > 0.0:
            cost += add_prior(H, g, x, i, prior[i], prior_info[i], prior_weight[i], limit)
        for k in range(start[i], start[i + 1]):
            if seen[k] >= 0:
                cost += add_bearing(H, g, x, i, seen[k], bearings[k], 1.0, var[k], limit)
    for k in range(len(mark_robot)):
        if mark_seen[k] >= 0:
            cost += add_mark(
                H, g, x, mark_robot[k], marks[mark_seen[k]], mark_bearing[k], 1.0, mark_var[k],
                limit,
            )  # fmt: skip
    return cost
