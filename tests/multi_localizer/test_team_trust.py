"""What is said when identities may be chance, rough poses lie, or a landmark is too close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from team_builders import GOALS, SIX, bearing, team

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_problem import make_problem
from multi_localizer.team_settle import settle
from multi_localizer.team_single import first_marks, place_alone, without_touched_marks
from multi_localizer.team_solver import solve_team
from multi_localizer.team_trust import contradicted_priors, doubted, liars, needed_trust, trust
from multi_localizer.team_views import NOBODY, RobotView


def test_bearings_that_all_return_are_trusted() -> None:
    views, _ = team(SIX)
    problem = make_problem(views, GOALS, TeamConfig())
    assert trust(problem, settle(problem, TeamConfig())) == pytest.approx(1.0)


def test_more_robots_and_more_noise_ask_for_more_trust() -> None:
    config = TeamConfig(least_trust=0.25)
    few = make_problem(team(SIX[:3], noise=0.01)[0], GOALS, config)
    # Chance: 1 - exp(-2 * 4 * 0.01 / (2 pi)) = 0.0127
    assert needed_trust(few, config) == pytest.approx(0.25 + 2.0 * 0.01265, abs=1e-4)
    many = make_problem(team(SIX, noise=0.01)[0], GOALS, config)
    noisy = make_problem(team(SIX, noise=0.03)[0], GOALS, config)
    assert needed_trust(few, config) < needed_trust(many, config) < needed_trust(noisy, config)


def test_robots_that_all_lie_are_placed_alone_and_that_is_said() -> None:
    views, _ = team(SIX)
    rng = np.random.default_rng(5)
    views = [replace(view, bearings=rng.uniform(-np.pi, np.pi, 5)) for view in views]
    solution = solve_team(views, GOALS)
    blind = solve_team([replace(view, bearings=np.zeros(0)) for view in views], GOALS)
    assert any("could not be settled" in note for note in solution.notes)
    for name, estimate in solution.estimates.items():
        assert np.all(solution.identities[name] == NOBODY)
        assert estimate.pose.x == pytest.approx(blind.estimates[name].pose.x, abs=1e-3)
        assert np.allclose(estimate.cov, blind.estimates[name].cov, rtol=0.02, atol=1e-6)


def test_rough_pose_that_landmarks_contradict_is_found() -> None:
    views, _ = team(SIX)
    wrong = PoseEstimate(SE2(0.0, 1.9, 1.0), np.diag([0.04, 0.04, 0.02]))
    views[5] = replace(views[5], rough=wrong)
    problem = make_problem(views, GOALS, TeamConfig())
    weight = np.ones(6)
    marks = first_marks(problem, weight, TeamConfig())
    said = contradicted_priors(problem, place_alone(problem, marks, weight), marks)
    assert list(np.flatnonzero(said)) == [5]


def test_landmark_on_top_of_which_a_robot_ends_is_left_out() -> None:
    place = GOALS["yellow"][0]
    pose = np.array([place[0] + 0.02, place[1] + 0.03, 0.5])
    seen = {kind: np.array([bearing(pose, marks[0])]) for kind, marks in GOALS.items()}
    rough = PoseEstimate(SE2(*pose), np.diag([0.01, 0.01, 0.01]))
    view = RobotView("r0", np.zeros(0), seen, rough=rough, bearing_sd=0.02)
    problem = make_problem([view], GOALS, TeamConfig())
    cleaned = without_touched_marks(problem, TeamConfig())
    assert [cleaned.kinds[kind] for kind in cleaned.mark_kind] == ["blue"]
    assert cleaned.notes == ("r0: too close to yellow to use it",)
    solution = solve_team([view], GOALS)
    assert solution.landmark_identities["r0"]["yellow"][0] == NOBODY
    assert solution.landmark_identities["r0"]["blue"][0] == 0


def test_liar_of_four_robots_is_found_only_if_nothing_it_says_fits() -> None:
    config = TeamConfig()
    problem = make_problem(team(SIX[:4])[0], GOALS, config)
    found = settle(problem, config)
    assert not liars(problem, found, config).any()
    seen = found.seen.copy()
    seen[3:6] = [-1, -1, seen[5]]
    assert not liars(problem, replace(found, seen=seen), config).any()
    seen[5] = -1
    assert list(np.flatnonzero(liars(problem, replace(found, seen=seen), config))) == [1]


def test_robot_whose_bearings_few_return_is_doubted() -> None:
    config = TeamConfig(returned_share=0.85)
    views, _ = team(np.vstack((SIX, SIX + [0.4, 0.7, 0.2])), seed=1)  # 11 bearings each
    problem = make_problem(views, GOALS, config)
    others = [np.delete(np.arange(12), i) for i in range(12)]
    seen = np.concatenate(others)
    # 0.85 * 11 - 3 sqrt(0.85 * 0.15 * 11) = 5.8 must be returned
    for returned, is_doubted in ((6, False), (5, True)):
        some = seen.copy()
        for j in range(1, 12 - returned):  # they say that they do not see robot 0
            some[problem.start[j]] = -1
        found = replace(settle(problem, config), seen=some)
        assert list(np.flatnonzero(doubted(problem, found, config))) == [0] * is_doubted
