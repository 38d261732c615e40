"""Normal equations and the fit of a team: residuals by hand, Jacobian, statistics of errors."""

from __future__ import annotations

import numpy as np
import pytest
from team_builders import GOALS, SIX, TRIANGLE, team, wrapped

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import fit_poses, normal_equations
from multi_localizer.team_linear import cholesky, inverse_cholesky, solve_cholesky
from multi_localizer.team_normal import bearing_residual, robust_cost, robust_weight, wrap
from multi_localizer.team_problem import TeamProblem, make_problem

PLAIN = 1e3
TOL = 1e-9


def all_seen(truth: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(truth).astype(np.int64)


def equations(
    problem: TeamProblem, x: np.ndarray, seen: np.ndarray, limit: float
) -> tuple[np.ndarray, np.ndarray, float]:
    size = 3 * len(x)
    H, g = np.zeros((size, size)), np.zeros(size)
    cost = normal_equations(
        H, g, x, problem.start, problem.bearings, problem.var, seen, problem.mark_robot,
        problem.mark_bearing, problem.mark_var, problem.marks,
        problem.kind_start[problem.mark_kind], problem.prior, problem.prior_info,
        np.ones(len(x)), limit,
    )  # fmt: skip
    return np.tril(H) + np.tril(H, -1).T, g, cost


def test_wrap_keeps_the_direction() -> None:
    assert wrap(3.5 * np.pi) == pytest.approx(-0.5 * np.pi)
    assert wrap(-0.25) == pytest.approx(-0.25)


def test_bearing_dead_ahead_has_no_residual() -> None:
    e, by_x, by_y = bearing_residual(0.0, 0.0, np.pi / 2.0, 0.0, 2.0, 0.0)
    assert e == pytest.approx(0.0, abs=TOL)
    assert (by_x, by_y) == pytest.approx((-0.5, 0.0), abs=TOL)


@pytest.mark.parametrize("limit", [PLAIN, 2.0])
def test_gradient_is_that_of_the_cost_by_finite_differences(limit: float) -> None:
    views, truth = team(SIX, noise=0.05)
    problem = make_problem(views, GOALS, TeamConfig())
    rng = np.random.default_rng(1)
    x = SIX + rng.normal(0.0, 0.05, SIX.shape)
    _, g, _ = equations(problem, x, all_seen(truth), limit)
    step = 1e-6
    for k in range(x.size):
        costs = []
        for sign in (1.0, -1.0):
            shifted = x.copy().ravel()
            shifted[k] += sign * step
            costs.append(equations(problem, shifted.reshape(-1, 3), all_seen(truth), limit)[2])
        slope = (costs[0] - costs[1]) / (2.0 * step)
        assert 2.0 * g[k] == pytest.approx(slope, rel=1e-4, abs=1e-2)


def test_normal_matrix_is_the_jacobian_squared_where_residuals_vanish() -> None:
    views, truth = team(TRIANGLE, noise=0.0, rough_sd=None)
    problem = make_problem(views, GOALS, TeamConfig())
    H, g, cost = equations(problem, TRIANGLE, all_seen(truth), PLAIN)
    assert cost == pytest.approx(0.0, abs=1e-3)
    step, size = 1e-5, TRIANGLE.size
    for k in range(size):
        shifted = TRIANGLE.copy().ravel()
        shifted[k] += step
        _, g_shifted, _ = equations(problem, shifted.reshape(-1, 3), all_seen(truth), PLAIN)
        assert np.allclose((g_shifted - g) / step, H[:, k], rtol=1e-3, atol=1e-3 * np.max(H))


def test_robust_weight_is_the_slope_of_the_robust_cost() -> None:
    for squared in (0.5, 3.9, 4.1, 50.0):
        slope = (robust_cost(squared + 1e-6, 2.0) - robust_cost(squared - 1e-6, 2.0)) / 2e-6
        assert robust_weight(squared, 2.0) == pytest.approx(slope, rel=1e-5)


def test_cholesky_solves_and_inverts() -> None:
    root = np.random.default_rng(2).normal(size=(7, 7))
    A, L = root @ root.T + np.eye(7), np.zeros((7, 7))
    assert cholesky(A, L)
    b = np.arange(7.0)
    assert np.allclose(A @ solve_cholesky(L, b), b)
    assert np.allclose(inverse_cholesky(L) @ A, np.eye(7))
    assert not cholesky(-A, L)


def test_exact_bearings_give_exact_poses_from_rough_ones() -> None:
    views, truth = team(SIX, noise=0.0)
    problem = make_problem(views, GOALS, TeamConfig())
    fit = fit_poses(
        problem, problem.prior, all_seen(truth), problem.kind_start[problem.mark_kind],
        np.full(6, 1e-9), PLAIN,
    )  # fmt: skip
    assert np.allclose(fit.poses[:, :2], SIX[:, :2], atol=1e-4)
    assert np.allclose(wrapped(fit.poses[:, 2] - SIX[:, 2]), 0.0, atol=1e-4)


def test_covariance_is_that_of_the_errors() -> None:
    squares = []
    for seed in range(60):
        views, truth = team(SIX, seed=seed, noise=0.02)
        problem = make_problem(views, GOALS, TeamConfig())
        marks = problem.kind_start[problem.mark_kind]
        fit = fit_poses(problem, problem.prior, all_seen(truth), marks, np.ones(6), PLAIN)
        e = fit.poses - SIX
        e[:, 2] = wrapped(e[:, 2])
        squares.append(e.ravel() @ np.linalg.solve(fit.cov, e.ravel()))
    assert np.mean(squares) == pytest.approx(18.0, abs=4.0 * np.sqrt(36.0 / 60.0))


def test_mutual_bearings_alone_leave_place_turn_and_size_open() -> None:
    views, truth = team(SIX, noise=0.01, rough_sd=None, landmarks={})
    problem = make_problem(views, {}, TeamConfig())
    none = np.zeros(0, dtype=np.int64)
    fit = fit_poses(problem, SIX, all_seen(truth), none, np.zeros(6), PLAIN)
    deviations = np.sqrt(np.linalg.eigvalsh(fit.cov))
    assert (deviations > 10.0).sum() == 4
    assert deviations[-5] < 1.0
