"""Other things located from the bearings of two and more robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from team_builders import GOALS, SIX, TRIANGLE, team

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_objects import locate_objects
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import RobotView, TeamSolution

BALLS = {"ball": np.array([[0.5, 0.2]])}


def known(poses: np.ndarray, sd: float) -> TeamSolution:
    names = tuple(f"r{k}" for k in range(len(poses)))
    cov = sd**2 * np.eye(3)
    return TeamSolution(
        names,
        {name: PoseEstimate(SE2(*pose), cov) for name, pose in zip(names, poses, strict=True)},
        joint_cov=sd**2 * np.eye(3 * len(poses)),
    )


def test_right_angled_crossing_by_hand() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [2.0, -2.0, 0.0]])
    views = [
        RobotView("r0", np.zeros(0), {}, {"ball": np.array([0.0])}, bearing_sd=0.01),
        RobotView("r1", np.zeros(0), {}, {"ball": np.array([np.pi / 2.0])}, bearing_sd=0.01),
    ]
    (ball,) = locate_objects(views, known(poses, 1e-9), TeamConfig())
    assert ball.position == pytest.approx([2.0, 0.0])
    # Each ray tells across itself, 2 m away: 2 m times 0.01 rad
    assert np.allclose(ball.cov, np.diag([0.02**2, 0.02**2]), rtol=1e-6)
    assert ball.seen_by == ("r0", "r1")


def test_two_things_of_one_class_are_told_apart() -> None:
    balls = {"ball": np.array([[0.5, 0.2], [-1.5, -0.4]])}
    views, _ = team(SIX, noise=0.005, objects=balls)
    found = locate_objects(views, known(SIX, 0.01), TeamConfig())
    assert [len(thing.seen_by) for thing in found] == [6, 6]
    places = sorted(tuple(thing.position) for thing in found)
    assert np.allclose(places, sorted(map(tuple, balls["ball"])), atol=0.05)


def test_one_robot_alone_locates_nothing() -> None:
    views, _ = team(TRIANGLE, objects=BALLS)
    views = [views[0], *(replace(view, object_bearings={}) for view in views[1:])]
    assert locate_objects(views, known(TRIANGLE, 0.01), TeamConfig()) == ()


def test_covariance_holds_the_errors_with_the_poses_own() -> None:
    squares = []
    for seed in range(25):
        views, _ = team(SIX, seed=seed, noise=0.02, objects=BALLS)
        (ball,) = solve_team(views, GOALS).objects
        e = ball.position - BALLS["ball"][0]
        squares.append(e @ np.linalg.solve(ball.cov, e))
    assert 0.9 < np.mean(squares) < 3.6  # mean 2, deviation 0.4
