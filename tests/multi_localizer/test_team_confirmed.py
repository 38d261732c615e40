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
    solution.identities["r0"][:] = NOBODY
    assert is_confirmed(solution, views, "r0", CONFIG)
    assert not is_confirmed(replace(solution, estimates={}), views, "r0", CONFIG)


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
