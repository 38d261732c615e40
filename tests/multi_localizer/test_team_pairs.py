"""Likelihoods of pairs, beliefs, hiding bodies and the search for a lost robot, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from team_builders import GOALS, SIX, TRIANGLE, team, wrapped

from multi_localizer.team_beliefs import beliefs
from multi_localizer.team_choice import best_owners, choose
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_hiding import visibility
from multi_localizer.team_marks import nearest_marks
from multi_localizer.team_pairs import (
    MAX_CANDIDATES,
    NONE,
    direction_covariance,
    nearest_bearings,
    pair_likelihoods,
    without_own,
)
from multi_localizer.team_problem import UNKNOWN, make_problem
from multi_localizer.team_relocate import nearest_table
from multi_localizer.team_yaws import settle_yaws


def block_cov(num: int, sd: tuple[float, float, float]) -> np.ndarray:
    return np.diag(np.tile(np.square(sd), num))


def test_direction_covariance_by_hand() -> None:
    x = np.array([[0.0, 0.0, 0.1], [2.0, 0.0, 0.4]])
    cov = block_cov(2, (0.1, 0.2, 0.05))
    phi, s11, s12, s22, more = direction_covariance(x, cov, 0, 1)
    across = (0.2**2 + 0.2**2) / 4.0  # both y over the distance
    assert phi == pytest.approx(0.0)
    assert (s11, s12, s22) == pytest.approx((across + 0.05**2, across, across + 0.05**2))
    assert more == pytest.approx(((2 * 0.1**2 + 2 * 0.2**2) / 8.0) ** 2)


def test_what_a_bearing_changed_is_taken_out_again() -> None:
    prior, noise = np.array([[0.04, 0.03], [0.03, 0.05]]), np.array([0.01, 0.02])
    innovation = np.array([0.1, -0.05])
    gain = prior @ np.linalg.inv(prior + np.diag(noise))
    after = prior - gain @ prior
    left = innovation - gain @ innovation
    s11, s12, s22, e1, e2 = without_own(
        after[0, 0], after[0, 1], after[1, 1], left[0], left[1], 1 / noise[0], 1 / noise[1]
    )
    assert [s11, s12, s22] == pytest.approx([0.04, 0.03, 0.05])
    assert [e1, e2] == pytest.approx(innovation)


def test_nearest_bearings_come_first_and_far_ones_not_at_all() -> None:
    bearings, into = np.array([0.5, 0.1, -0.05, 3.0]), np.full(MAX_CANDIDATES, -1)
    var, known = np.full(4, 0.01), np.full(4, UNKNOWN)
    room = np.empty(MAX_CANDIDATES)
    found = nearest_bearings(into, 0, 4, bearings, var, known, 1, 0.0, 0.03, 3.0, room)
    assert list(into[:found]) == [2, 1, 0]
    known[2] = 7  # said to be another robot's
    found = nearest_bearings(into, 0, 4, bearings, var, known, 1, 0.0, 0.03, 3.0, room)
    assert list(into[:found]) == [1, 0]


def test_exact_views_are_believed() -> None:
    views, truth = team(TRIANGLE, noise=0.01)
    problem = make_problem(views, {}, TeamConfig())
    none = np.full(6, -1)
    candidates, counts, likelihoods = pair_likelihoods(
        TRIANGLE, block_cov(3, (0.05, 0.05, 0.02)), problem.start, problem.bearings, problem.var,
        problem.known, none, 1e3, np.ones((3, 3)), 4.0, 0.95, 0.02,
    )  # fmt: skip
    sure = beliefs(candidates, counts, likelihoods, 6, 15)
    owner, belief = best_owners(candidates, counts, sure, 6)
    assert np.array_equal(owner, np.concatenate(truth))
    assert belief.min() > 0.99
    assert likelihoods[0, 1, NONE, NONE] == pytest.approx(0.05**2)


def test_two_robots_in_one_direction_share_one_bearing() -> None:
    likelihoods = np.zeros((3, 3, MAX_CANDIDATES + 1, MAX_CANDIDATES + 1))
    candidates = np.full((3, 3, MAX_CANDIDATES), -1)
    counts = np.zeros((3, 3), dtype=np.int64)
    for j, like in ((1, 3.0), (2, 1.0)):
        candidates[0, j, 0], counts[0, j] = 0, 1
        likelihoods[0, j, 0, NONE], likelihoods[0, j, NONE, NONE] = like, 1.0
    sure = beliefs(candidates, counts, likelihoods, 1, 50)
    # Nobody, the first, the second: 1 to 3 to 1
    assert (sure[0, 1, 0], sure[0, 2, 0]) == pytest.approx((0.6, 0.2), abs=1e-3)


def test_only_the_surest_begin_to_count() -> None:
    owner = np.arange(400)
    belief = np.linspace(0.9, 0.99, 400)
    seen = choose(owner, belief, np.full(400, -1), 0.95, 0.1)
    assert list(np.flatnonzero(seen >= 0)) == list(range(360, 400))
    few = choose(owner[:60], belief[-60:], np.full(60, -1), 0.95, 0.1)
    assert list(np.flatnonzero(few >= 0)) == list(range(35, 60))
    kept = choose(owner, np.full(400, 0.6), owner, 0.95, 0.1)
    assert np.array_equal(kept, owner)


def test_body_between_hides_and_one_beside_does_not() -> None:
    x = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 0.05, 0.0], [2.0, 1.0, 0.0]])
    chance = visibility(x, block_cov(4, (1e-3, 1e-3, 0.1)), 0.15, 0.02)
    assert chance[0, 1] == chance[1, 0] == pytest.approx(0.02)
    assert chance[0, 2] == pytest.approx(1.0)
    assert chance[0, 3] == pytest.approx(1.0)


def test_only_landmark_of_its_class_needs_no_pose_and_of_two_the_near_one_counts() -> None:
    marks = np.array([[4.0, 0.0], [0.0, 3.0], [0.0, -3.0]])
    x, kind_start = np.zeros((1, 3)), np.array([0, 1, 3])
    said = nearest_marks(
        x, block_cov(1, (0.1, 0.1, 0.1)), np.zeros(3, int), np.array([0, 1, 1]),
        np.array([2.0, 1.5, 0.2]), np.full(3, 0.01), marks, kind_start, 4.0,
    )  # fmt: skip
    assert list(said) == [0, 1, -1]


def test_pattern_of_bearings_tells_the_yaw() -> None:
    views, _ = team(SIX, noise=0.01, landmarks={})
    problem = make_problem(views, {}, TeamConfig())
    x = SIX.copy()
    x[:, 2] += np.array([0.3, -0.25, 0.2, -0.3, 0.25, 0.1])
    cov = block_cov(6, (0.1, 0.1, 0.26))
    settled, settled_cov = settle_yaws(
        x, cov, problem.start, problem.bearings, problem.var, 0.1, 5.0
    )
    assert np.abs(wrapped(settled[:, 2] - SIX[:, 2])).max() < 0.06
    assert np.diag(settled_cov)[2::3].max() < 0.1**2
    assert np.linalg.eigvalsh(settled_cov)[0] > 0.0


def test_table_names_the_nearest_open_bearing() -> None:
    start, bearings = np.array([0, 2, 2]), np.array([-1.0, 1.0])
    table = nearest_table(start, bearings, np.array([True, True]))
    assert (table[0, 0], table[0, 100], table[0, 150]) == (1, 0, 1) or table[0, 100] == 0
    assert np.all(table[1] == -1)
    assert np.all(nearest_table(start, bearings, np.array([False, True]))[0] == 1)


def test_landmarks_of_unknown_class_are_said() -> None:
    views, _ = team(TRIANGLE, landmarks=GOALS)
    problem = make_problem(views, {"yellow": GOALS["yellow"]}, TeamConfig())
    assert len(problem.mark_robot) == 3
    assert problem.notes[0] == "r0: nobody knows where blue is"
