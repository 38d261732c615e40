"""The team's poses and identities from all views: geometry first, then one fit of everything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit, fit_poses
from multi_localizer.team_objects import locate_objects
from multi_localizer.team_observability import unknown_poses, words
from multi_localizer.team_problem import TeamProblem, make_problem, to_views
from multi_localizer.team_settle import settle
from multi_localizer.team_single import telling_marks, without_touched_marks
from multi_localizer.team_state import Identification
from multi_localizer.team_trust import doubted, liars, needed_trust, trust, without
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution, view_problem

_TOO_FEW = 3  # robots: bearings get other owners until they fit a wrong rough pose, too


def solve_team(
    views: Sequence[RobotView],
    landmarks: Mapping[str, np.ndarray],
    config: TeamConfig | None = None,
) -> TeamSolution:
    """Tell who is who and where every robot is.

    Args:
        views: Of all robots of the team; their names must differ.
        landmarks: Positions by class in the map frame, (K, 2) each, m; may be empty.
        config: Tuning.
    """
    config = TeamConfig() if config is None else config
    names = tuple(view.name for view in views)
    problem_text = view_problem(views)
    if problem_text:
        return TeamSolution(names, problem=problem_text)
    problem = without_touched_marks(make_problem(views, landmarks, config), config)
    found, suspects, notes = _believed(problem, settle(problem, config), config)
    fit = _final_fit(problem, found, config)
    solution = _solution(problem, views, found, fit, config)
    notes = (*problem.notes, *notes, *_unsafe(problem, found))
    solution = replace(solution, suspects=suspects, notes=notes)
    objects = locate_objects(views, solution, config)
    return replace(solution, objects=objects)


def _unsafe(problem: TeamProblem, found: Identification) -> tuple[str, ...]:
    """Return what is to be said where nothing would contradict a wrong rough pose."""
    num, has_mark = problem.num_robots, bool((found.mark_seen >= 0).any())
    if not 1 < num <= _TOO_FEW or has_mark or not problem.has_prior.any():
        return ()
    return (f"{num} robots without landmarks: a wrong own pose of one of them may go unnoticed",)


def _believed(
    problem: TeamProblem, found: Identification, config: TeamConfig
) -> tuple[Identification, tuple[str, ...], tuple[str, ...]]:
    """Return what of the identities is believed, the suspects, and what is to be said of both."""
    value = trust(problem, found)
    if value < needed_trust(problem, config):
        everyone = np.ones(problem.num_robots, dtype=np.bool_)
        note = f"identities could not be settled (trust {value:.2f}): each robot is placed alone"
        alone = without(problem, found, everyone, also_to=True)
        weight = problem.has_prior.astype(float)
        if len(problem.marks):
            alone = replace(alone, mark_seen=telling_marks(problem, alone.mark_seen, weight))
        return replace(alone, prior_weight=weight), (), (note,)
    lying = liars(problem, found, config)
    moved = problem.has_prior & (found.prior_weight == 0.0)
    names = np.array(problem.names)
    notes = [f"{name}: its bearings fit nobody and are left out" for name in names[lying]]
    notes += [f"{name}: its rough pose is contradicted and left out" for name in names[moved]]
    found = without(problem, found, lying, also_to=False)
    in_doubt = doubted(problem, found, config) & ~lying
    notes += [f"{name}: few return its bearings: placed alone" for name in names[in_doubt]]
    found = without(problem, found, in_doubt, also_to=True)
    return found, tuple(str(name) for name in names[lying | moved]), tuple(notes)


def _final_fit(problem: TeamProblem, found: Identification, config: TeamConfig) -> TeamFit:
    """Fit once more, with those rough poses only that are evidence of their own."""
    weight = np.where(problem.prior_counts, found.prior_weight, 0.0)
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    is_in = np.zeros(problem.num_robots, dtype=np.bool_)
    is_in[owners[found.seen >= 0]] = True
    is_in[found.seen[found.seen >= 0]] = True
    start = np.where(is_in[:, None] | ~problem.has_prior[:, None], found.fit.poses, problem.prior)
    return fit_poses(problem, start, found.seen, found.mark_seen, weight, config.gate_sd)


def _solution(
    problem: TeamProblem, views: Sequence[RobotView], found: Identification, fit: TeamFit,
    config: TeamConfig,
) -> TeamSolution:  # fmt: skip
    unknown = unknown_poses(fit, config)
    located = [i for i in range(problem.num_robots) if not unknown[i]]
    rows = np.concatenate([np.arange(3 * i, 3 * i + 3) for i in located] or [np.zeros(0, int)])
    return TeamSolution(
        names=problem.names,
        estimates={
            problem.names[i]: PoseEstimate(
                SE2(*(float(value) for value in fit.poses[i])),
                fit.cov[3 * i : 3 * i + 3, 3 * i : 3 * i + 3],
            )
            for i in located
        },
        identities=to_views(problem, views, np.where(found.belief > 0.5, found.owner, NOBODY)),
        landmark_identities=_landmark_identities(problem, views, found),
        unobservable=words(problem, fit, found, unknown),
        joint_cov=fit.cov[np.ix_(rows, rows)],
    )


def _landmark_identities(
    problem: TeamProblem, views: Sequence[RobotView], found: Identification
) -> dict[str, dict[str, np.ndarray]]:
    result = {
        view.name: {
            kind: np.full(len(bearings), NOBODY, dtype=np.int64)
            for kind, bearings in view.landmark_bearings.items()
        }
        for view in views
    }
    for k, mark in enumerate(found.mark_seen):
        kind = problem.mark_kind[k]
        ids = result[problem.names[problem.mark_robot[k]]][problem.kinds[kind]]
        ids[problem.mark_source[k]] = NOBODY if mark < 0 else mark - problem.kind_start[kind]
    return result
