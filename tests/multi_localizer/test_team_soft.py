"""Tests of soft beliefs: mixtures as one Gaussian bearing, and a crowd settled by them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from team_builders import GOALS, team

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_crowd import settle_crowd
from multi_localizer.team_problem import make_problem
from multi_localizer.team_soft import as_bearings, mixture, update_aims

VAR = 0.01
SPREAD = 0.04


def mixed(beliefs: list[float], bearings: list[float], expected: float = 0.0):
    at = np.arange(len(beliefs))
    var = np.full(len(beliefs), VAR)
    return mixture(at, np.array(beliefs), np.array(bearings), var, expected, SPREAD)


def test_sure_bearing_stays_as_it_is() -> None:
    info, value = mixed([1.0], [0.1])
    assert info == pytest.approx(1.0 / VAR, rel=0.01)
    assert value == pytest.approx(0.1, abs=1e-3)


def test_half_believed_bearing_at_the_expected_place_by_hand() -> None:
    # left = (SPREAD + SPREAD VAR / (SPREAD + VAR)) / 2 = 0.024; info = 1 / 0.024 - 1 / 0.04
    info, value = mixed([0.5], [0.0])
    assert info == pytest.approx(1.0 / 0.024 - 25.0)
    assert value == pytest.approx(0.0)


def test_two_rivals_far_apart_say_nothing() -> None:
    info, _ = mixed([0.5, 0.5], [-0.3, 0.3])
    assert info == 0.0


def test_mixture_across_pi_is_as_elsewhere() -> None:
    info, value = mixed([0.7, 0.2], [0.02, -0.05])
    over, moved = mixed([0.7, 0.2], [np.pi - 0.01 + 0.02 - 2 * np.pi, np.pi - 0.06], np.pi - 0.01)
    assert over == pytest.approx(info)
    assert moved - np.pi + 0.01 == pytest.approx(value)


@given(st.floats(0.01, 1.0), st.floats(-0.3, 0.3))
def test_mixture_never_says_more_than_the_bearing(belief: float, bearing: float) -> None:
    info, _ = mixed([belief], [bearing])
    assert 0.0 <= info <= (1.0 + 1e-9) / VAR


def test_aims_keep_part_of_what_they_were() -> None:
    info, aim = np.array([[0.0, 40.0], [0.0, 0.0]]), np.array([[0.0, 0.2], [0.0, 0.0]])
    counts = np.zeros((2, 2), dtype=np.int64)
    candidates, sure = np.zeros((2, 2, 8), dtype=np.int64), np.zeros((2, 2, 8))
    bearings, var = np.zeros(1), np.full(1, VAR)
    update_aims(
        info, aim, candidates, counts, sure, bearings, var, np.zeros((2, 2)), np.ones((2, 2)), 0.5
    )
    assert info[0, 1] == pytest.approx(20.0)
    assert aim[0, 1] == pytest.approx(0.2)
    start, values, variances, seen = as_bearings(info, aim)
    assert list(start) == [0, 1, 1]
    assert (values[0], variances[0], seen[0]) == pytest.approx((0.2, 0.05, 1))


@pytest.mark.parametrize("seed", [3, 4])
def test_rough_poses_as_bad_as_the_gaps_are_settled_without_landmarks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.arange(4) * 1.4, np.arange(3) * 1.4), axis=-1).reshape(-1, 2)
    places = grid + rng.uniform(-0.3, 0.3, grid.shape)
    poses = np.column_stack((places, rng.uniform(-np.pi, np.pi, len(places))))
    views, truth = team(poses, seed=seed, rough_sd=(0.5, 0.5, 0.4), landmarks={})
    config = TeamConfig(body_radius_m=0.0)
    problem = make_problem(views, {}, config)
    found = settle_crowd(problem, config)
    right = found.owner[problem.start[:-1, None] + np.arange(11)] == np.array(truth)
    assert right.mean() > 0.95


def test_landmarks_and_false_bearings_do_not_disturb_a_crowd() -> None:
    rng = np.random.default_rng(5)
    places = np.stack(np.meshgrid(np.arange(3) * 1.5, np.arange(3) * 1.5), axis=-1).reshape(-1, 2)
    places += rng.uniform(-0.3, 0.3, places.shape)
    poses = np.column_stack((places, rng.uniform(-np.pi, np.pi, len(places))))
    views, truth = team(poses, seed=5, rough_sd=(0.4, 0.4, 0.3), landmarks=GOALS)
    config = TeamConfig(body_radius_m=0.0)
    problem = make_problem(views, GOALS, config)
    problem.bearings[0] += 1.0
    found = settle_crowd(problem, config)
    owner = np.where(found.belief > 0.5, found.owner, -1)
    right = owner[problem.start[:-1, None] + np.arange(8)] == np.array(truth)
    assert right.sum() >= right.size - 5
    assert np.all(np.hypot(*(found.fit.poses - poses)[:, :2].T) < 0.2)
