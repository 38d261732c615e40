"""A suspect's pose is said only where its teammates fix it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from team_builders import GOALS, SIX, team

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_confirmed import is_confirmed
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

FOUR = SIX[[0, 1, 3, 4]]
SURE = np.diag([0.02**2, 0.02**2, 0.01**2])
CONFIG = TeamConfig()


def told(
    suspects: tuple[str, ...] = ("r0",), off: float = 0.0, noise: float = 0.001
) -> tuple[TeamSolution, list[RobotView]]:
    """Return true poses and identities, robot r0 moved by `off`."""
    views, truth = team(FOUR, noise=noise, landmarks={})
    poses = {f"r{k}": SE2(*pose) for k, pose in enumerate(FOUR)}
    poses["r0"] = SE2(poses["r0"].x + off, poses["r0"].y, poses["r0"].yaw)
    names = tuple(poses)
    return TeamSolution(
        names, {name: PoseEstimate(pose, SURE) for name, pose in poses.items()},
        {name: ids.copy() for name, ids in zip(names, truth, strict=True)}, suspects=suspects,
    ), views  # fmt: skip


def test_who_is_no_suspect_needs_no_witness_but_a_pose() -> None:
    solution, views = told(suspects=())
    for name in ("r1", "r2", "r3"):
        solution.identities[name][:] = NOBODY
    assert is_confirmed(solution, views, "r0", CONFIG)
    assert not is_confirmed(replace(solution, estimates={}), views, "r0", CONFIG)


@pytest.mark.parametrize(
    ("num_fitting", "num_bearings", "is_said"),
    [(3, 3, True), (2, 3, False), (3, 4, True), (2, 4, False), (4, 5, True), (3, 5, False),
     (1, 6, True), (0, 0, True)],
)  # fmt: skip
def test_of_few_bearings_three_quarters_must_fit_somebody(
    num_fitting: int, num_bearings: int, is_said: bool
) -> None:
    solution, views = told(suspects=())
    ids = np.array([1] * num_fitting + [NOBODY] * (num_bearings - num_fitting), dtype=np.int64)
    solution = replace(solution, identities={**solution.identities, "r0": ids})
    assert is_confirmed(solution, views, "r0", CONFIG) == is_said


def test_landmarks_that_fit_speak_for_a_robot_as_teammates_do() -> None:
    solution, views = told(suspects=())
    solution.identities["r0"][1:] = NOBODY
    for num_marks, is_said in ((4, False), (5, True)):  # 5 of 7, 6 of 8
        marks = {"r0": {"pole": np.arange(num_marks)}}
        assert is_confirmed(
            replace(solution, landmark_identities=marks), views, "r0", CONFIG
        ) == is_said  # fmt: skip


def test_a_bearing_to_each_robot_that_tells_nothing_may_be_nobodys() -> None:
    solution, views = told(suspects=())
    solution.identities["r0"][2:] = NOBODY
    assert not is_confirmed(solution, views, "r0", CONFIG)
    assert is_confirmed(solution, views, "r0", CONFIG, num_away=1)
    blind = [replace(view, bearings=np.zeros(0)) if view.name == "r2" else view for view in views]
    assert is_confirmed(solution, blind, "r0", CONFIG)
    solution.identities["r0"][1:] = NOBODY
    assert not is_confirmed(solution, views, "r0", CONFIG, num_away=1)


def test_a_robot_of_four_that_was_carried_away_rarely_gets_a_wrong_pose_published() -> None:
    wrong = honest = 0
    for seed in range(30):
        views, _ = team(FOUR, seed=seed, noise=0.0175, landmarks={})
        rough = views[0].rough
        assert rough is not None
        away = SE2(rough.pose.x + 3.0, rough.pose.y, rough.pose.yaw + 1.0)
        views[0] = replace(views[0], rough=PoseEstimate(away, rough.cov))
        solution = solve_team(views, {}, CONFIG)
        for k, name in enumerate(solution.names):
            if is_confirmed(solution, views, name, CONFIG):
                pose = solution.estimates[name].pose.as_array()
                is_off = np.hypot(*(pose - FOUR[k])[:2]) > 1.5
                wrong += is_off and k == 0
                honest += not is_off and k > 0
    assert wrong <= 2 and honest >= 45


def test_a_suspect_whom_three_see_where_it_is_said_to_be_is_confirmed() -> None:
    solution, views = told()
    assert is_confirmed(solution, views, "r0", CONFIG)


def test_a_suspect_of_whose_bearings_some_fit_by_chance_is_not() -> None:
    for kept in (0, 1, 2):
        solution, views = told()
        solution.identities["r0"][kept:] = NOBODY
        assert not is_confirmed(solution, views, "r0", CONFIG)


def test_a_suspect_whose_landmarks_do_not_fit_is_not() -> None:
    solution, views = told()
    marks = {"pole": np.full(4, NOBODY)}
    assert not is_confirmed(
        replace(solution, landmark_identities={"r0": marks}), views, "r0", CONFIG
    )


def test_a_suspect_elsewhere_than_the_others_see_it_is_not() -> None:
    for off, is_so in ((0.02, True), (0.5, False)):
        solution, views = told(off=off)
        assert is_confirmed(solution, views, "r0", CONFIG) == is_so


@pytest.mark.parametrize("num_seeing", [0, 1])
def test_one_ray_fixes_no_place(num_seeing: int) -> None:
    solution, views = told()
    for name in ("r1", "r2", "r3")[num_seeing:]:
        ids = solution.identities[name]
        ids[ids == 0] = NOBODY
    assert not is_confirmed(solution, views, "r0", CONFIG)


def test_another_suspect_is_no_witness() -> None:
    solution, views = told(suspects=("r0", "r1", "r2"))
    assert not is_confirmed(solution, views, "r0", CONFIG)


def test_made_up_bearings_in_a_team_of_four_do_not_get_a_wrong_pose_published() -> None:
    rng = np.random.default_rng(1)
    suspected = wrong = 0
    for seed in range(40):
        views, _ = team(FOUR, seed=seed, noise=0.0175)
        views[0] = replace(
            views[0], bearings=rng.uniform(-np.pi, np.pi, 3),
            landmark_bearings={kind: rng.uniform(-np.pi, np.pi, 1) for kind in GOALS},
        )  # fmt: skip
        solution = solve_team(views, GOALS, CONFIG)
        if "r0" not in solution.suspects:
            continue
        suspected += 1
        if is_confirmed(solution, views, "r0", CONFIG):
            pose = solution.estimates["r0"].pose
            wrong += np.hypot(*(pose.as_array() - FOUR[0])[:2]) > 0.5
    assert suspected >= 5 and wrong == 0
