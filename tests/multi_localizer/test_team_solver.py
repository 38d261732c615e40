"""Identities and poses of a whole team: by hand, laws, faults, and what is said of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from team_builders import GOALS, SIX, TRIANGLE, bearing, team, wrapped

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, normalized_error
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution
from multi_localizer.team_warm_up import warm_up

TOL_M = 0.15


def errors(solution: TeamSolution, poses: np.ndarray) -> np.ndarray:
    places = [(e.pose.x, e.pose.y) for e in solution.estimates.values()]
    return np.hypot(*(np.array(places) - poses[:, :2]).T)


def assert_right(solution: TeamSolution, truth: list[np.ndarray]) -> None:
    for k, ids in enumerate(truth):
        assert np.array_equal(solution.identities[f"r{k}"], ids)


@pytest.mark.parametrize("seed", range(3))
def test_six_robots_are_told_apart_and_placed(seed: int) -> None:
    views, truth = team(SIX, seed=seed)
    solution = solve_team(views, GOALS)
    assert_right(solution, truth)
    assert list(solution.estimates) == list(solution.names)
    assert errors(solution, SIX).max() < TOL_M
    assert (solution.problem, solution.unobservable, solution.suspects) == ("", "", ())


def test_rough_poses_alone_settle_identities_without_landmarks() -> None:
    views, truth = team(SIX, seed=1, landmarks={}, rough_sd=(0.3, 0.3, 0.25))
    assert_right(solve_team(views, {}), truth)


def test_covariances_hold_the_errors() -> None:
    squares = []
    for seed in range(25):
        views, _ = team(SIX, seed=seed, noise=0.02)
        solution = solve_team(views, GOALS)
        squares += [
            normalized_error(estimate.pose, SE2(*pose), estimate.cov)
            for estimate, pose in zip(solution.estimates.values(), SIX, strict=True)
        ]
    assert 2.0 < np.mean(squares) < 4.2


def test_moving_team_and_landmarks_moves_the_answer() -> None:
    T = SE2(1.5, -2.0, 0.8)
    views, _ = team(SIX)
    moved = [
        replace(v, rough=PoseEstimate(T @ v.rough.pose, turned(v.rough.cov, T.yaw)))
        for v in views
        if v.rough is not None
    ]
    there = solve_team(moved, {kind: T @ places for kind, places in GOALS.items()})
    for name, estimate in solve_team(views, GOALS).estimates.items():
        expected = T @ estimate.pose
        assert there.estimates[name].pose.x == pytest.approx(expected.x, abs=1e-3)
        assert there.estimates[name].pose.y == pytest.approx(expected.y, abs=1e-3)
        assert np.allclose(
            there.estimates[name].cov, turned(estimate.cov, T.yaw), rtol=0.05, atol=1e-5
        )


def turned(cov: np.ndarray, yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return R @ cov @ R.T


def test_order_of_robots_does_not_matter() -> None:
    views, _ = team(SIX)
    straight, reverse = solve_team(views, GOALS), solve_team(views[::-1], GOALS)
    for name, estimate in straight.estimates.items():
        assert reverse.estimates[name].pose.x == pytest.approx(estimate.pose.x, abs=1e-3)
        said = [reverse.names[k] for k in reverse.identities[name]]
        assert said == [straight.names[k] for k in straight.identities[name]]


def test_false_bearing_is_nobodys_and_a_missing_robot_is_missed() -> None:
    views, truth = team(SIX)
    first = views[0]
    views[0] = replace(first, bearings=np.append(first.bearings[1:], first.bearings[0] + 0.35))
    solution = solve_team(views, GOALS)
    assert solution.identities["r0"][-1] == NOBODY
    assert np.array_equal(solution.identities["r0"][:-1], truth[0][1:])


def test_wrong_rough_pose_is_found_out_and_left_out() -> None:
    views, truth = team(SIX)
    rough = PoseEstimate(SE2(-2.0, 1.5, 2.0), np.diag([0.04, 0.04, 0.02]))
    views[4] = replace(views[4], rough=rough)
    solution = solve_team(views, GOALS)
    assert_right(solution, truth)
    assert solution.suspects == ("r4",)
    assert errors(solution, SIX).max() < TOL_M


def test_robot_without_rough_pose_is_found_by_the_others() -> None:
    views, truth = team(SIX)
    views[2] = replace(views[2], rough=None)
    solution = solve_team(views, GOALS)
    assert_right(solution, truth)
    assert errors(solution, SIX).max() < TOL_M


def test_liars_bearings_are_nobodys() -> None:
    views, truth = team(SIX)
    views[3] = replace(views[3], bearings=np.random.default_rng(7).uniform(-np.pi, np.pi, 5))
    solution = solve_team(views, GOALS)
    assert solution.suspects == ("r3",)
    assert np.all(solution.identities["r3"] == NOBODY)
    for k in (0, 1, 2, 4, 5):
        assert np.array_equal(solution.identities[f"r{k}"], truth[k])
    assert errors(solution, SIX).max() < 3.0 * TOL_M


def test_nan_is_left_out_and_said() -> None:
    views, truth = team(SIX)
    broken = views[1].bearings.copy()
    broken[2] = np.nan
    views[1] = replace(views[1], bearings=broken)
    solution = solve_team(views, GOALS)
    assert solution.identities["r1"][2] == NOBODY
    assert np.array_equal(np.delete(solution.identities["r1"], 2), np.delete(truth[1], 2))
    assert any("r1" in note and "not finite" in note for note in solution.notes)


def test_given_names_are_kept() -> None:
    views, truth = team(SIX)
    named = [
        replace(view, known=tuple(f"r{k}" for k in ids))
        for view, ids in zip(views, truth, strict=True)
    ]
    assert_right(solve_team(named, GOALS), truth)


def test_no_pose_is_given_where_nothing_tells_it() -> None:
    views, _ = team(SIX, landmarks={}, rough_sd=None)
    solution = solve_team(views, {})
    assert not solution.estimates
    assert "no pose of r0, r1, r2, r3, r4, r5" in solution.unobservable
    assert "place" in solution.unobservable


def test_size_is_open_for_robots_in_one_line() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [3.0, 0.0, 2.0]])
    views, _ = team(poses, noise=0.001, landmarks={}, rough_sd=(0.3, 0.3, 0.2))
    solution = solve_team(views, {})
    along = [np.sqrt(e.cov[0, 0]) for e in solution.estimates.values()]
    assert min(along) > 0.25  # bearings along the line say nothing of the places on it


def test_two_robots_of_one_name_are_refused() -> None:
    views, _ = team(TRIANGLE)
    views[1] = replace(views[1], name="r0")
    solution = solve_team(views, GOALS)
    assert not solution.estimates
    assert "'r0'" in solution.problem


def test_nobody_is_a_problem_and_one_robot_is_placed_by_its_rough_pose() -> None:
    assert solve_team([], GOALS).problem == "no robot"
    rough = PoseEstimate(SE2(1.0, 1.0, 0.0), 0.01 * np.eye(3))
    alone = solve_team([RobotView("r0", np.zeros(0), rough=rough)], {})
    assert alone.estimates["r0"].pose.x == pytest.approx(1.0)
    assert np.allclose(alone.estimates["r0"].cov, 0.01 * np.eye(3), rtol=1e-3)


def test_rough_pose_from_the_same_landmarks_is_not_counted_twice() -> None:
    pose = np.array([0.5, -1.0, 0.4])
    marks = {
        "a": np.array([[4.0, 1.0]]),
        "b": np.array([[4.0, -1.0]]),
        "c": np.array([[-4.0, 0.0]]),
    }
    seen = {kind: np.array([bearing(pose, place[0])]) for kind, place in marks.items()}
    rough = PoseEstimate(SE2(*pose), 1e-4 * np.eye(3))
    view = RobotView("r0", np.zeros(0), seen, rough=rough, bearing_sd=0.05)
    twice = solve_team([view], marks).estimates["r0"]
    once = solve_team([replace(view, rough_from_landmarks=True)], marks).estimates["r0"]
    assert np.trace(once.cov) > 10.0 * np.trace(twice.cov)
    assert np.allclose(wrapped(once.pose.yaw - pose[2]), 0.0, atol=1e-3)


def test_robots_of_which_nothing_is_known_end_the_solver_in_words_not_in_an_error() -> None:
    warm_up(TeamConfig())  # one of its two teams has a single rough pose and no landmark
    poses = np.array([[0.0, 0.0, 0.0], [3.0, 0.5, 0.0], [1.0, 2.5, 0.0], [2.5, 3.5, 0.0]])
    views, _ = team(poses, noise=0.0, landmarks={})
    views = [views[0], *(replace(view, rough=None) for view in views[1:])]
    assert "no pose of" in solve_team(views, {}).unobservable


@pytest.mark.parametrize("sd", [10.0, 100.0, 1000.0])
def test_a_rough_pose_that_nobody_knows_is_as_none(sd: float) -> None:
    views, _ = team(SIX, seed=3)
    away = SE2(40.0, -7.0, 0.0)
    vague = replace(views[2], rough=PoseEstimate(away, np.diag([sd**2, sd**2, 0.1])))
    without = solve_team([replace(v, rough=None) if v is views[2] else v for v in views], GOALS)
    said = solve_team([vague if v is views[2] else v for v in views], GOALS)
    assert said.notes == ("r2: its rough pose is too uncertain and left out",)
    assert without.notes == () and list(said.estimates) == list(said.names)
    for name, estimate in said.estimates.items():
        assert estimate.pose == without.estimates[name].pose
        assert np.array_equal(estimate.cov, without.estimates[name].cov)


def test_three_robots_without_landmarks_are_told_that_nothing_holds_up_their_own_poses() -> None:
    note = "3 robots without landmarks: a wrong own pose of one of them may go unnoticed"
    assert solve_team(team(TRIANGLE, landmarks={})[0], {}).notes == (note,)
    assert solve_team(team(TRIANGLE)[0], GOALS).notes == ()
    assert solve_team(team(SIX[:4], landmarks={})[0], {}).notes == ()
