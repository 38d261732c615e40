"""Who is who in the bearings of a team, settled by the geometry of all of them together.

Rounds of: weigh each pair of bearings that two robots may have of each other under the joint
covariance of all poses (`team_pairs`); let pairs and bearings agree on beliefs (`team_beliefs`);
fit all poses to the bearings believed in (`team_fit`). With each round the covariance shrinks,
and what was ambiguous is not any more. Nothing is final before the last round.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multi_localizer.team_beliefs import beliefs
from multi_localizer.team_choice import best_owners, choose
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit, fit_poses
from multi_localizer.team_hiding import visibility
from multi_localizer.team_pairs import pair_likelihoods
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_single import find_marks, first_marks, place_alone
from multi_localizer.team_state import PLAIN, Identification
from multi_localizer.team_trust import contradicted_priors
from multi_localizer.team_yaws import settle_yaws

_LEVELS = (0.95, 0.6)
_FEW = 0.007  # share of the bearings that may change in a settled round
_FEW_STEPS = 10  # of the fit within a round; the next one goes on


def identify(problem: TeamProblem, prior_weight: np.ndarray, config: TeamConfig) -> Identification:
    """Settle identities, starting from rough poses and landmarks.

    Args:
        problem: The views.
        prior_weight: What each rough pose counts, (N,), 0..1.
        config: Tuning.
    """
    first = place_first(problem, prior_weight, config)
    x, cov = settle_yaws(
        first.fit.poses, first.fit.cov, problem.start, problem.bearings, problem.var,
        config.loose_yaw_rad, config.far_sd_m,
    )  # fmt: skip
    start = replace(first, fit=TeamFit(x, cov, first.fit.cost))
    return refine(problem, start, config, config.max_rounds)


def place_first(
    problem: TeamProblem, prior_weight: np.ndarray, config: TeamConfig
) -> Identification:
    """Return each robot where it is by itself, nobody identified; arguments as in `identify`."""
    none = np.full(len(problem.bearings), -1, dtype=np.int64)
    marks = first_marks(problem, prior_weight, config)
    alone = place_alone(problem, marks, prior_weight)
    wrong = contradicted_priors(problem, alone, marks)
    if wrong.any():
        prior_weight = np.where(wrong, 0.0, prior_weight)
        alone = place_alone(problem, marks, prior_weight)
    return Identification(none, np.zeros(len(none)), none, marks, prior_weight, alone)


def refine(
    problem: TeamProblem, state: Identification, config: TeamConfig, max_rounds: int
) -> Identification:
    """Go on from poses that are known somehow, round by round, until nothing changes."""
    level = 0
    for turn in range(max_rounds):
        weighed = believe(problem, state, config)
        seen = choose(weighed.owner, weighed.belief, state.seen, _LEVELS[level], config.new_share)
        marks = find_marks(problem, state.fit, config)
        num_changed = np.sum(seen != state.seen) + np.sum(marks != state.mark_seen)
        is_settled = num_changed <= _FEW * len(seen)
        limit = PLAIN if turn < 2 else config.gate_sd
        fit = fit_poses(
            problem, state.fit.poses, seen, marks, state.prior_weight, limit, _FEW_STEPS
        )
        state = replace(weighed, seen=seen, mark_seen=marks, fit=fit, limit=limit)
        if is_settled:
            level += 1
            if level == len(_LEVELS):
                break
    return state


def believe(
    problem: TeamProblem, state: Identification, config: TeamConfig,
    is_there: np.ndarray | None = None,
) -> Identification:  # fmt: skip
    """Return who is who at poses as they are, among those robots that are there, (N,) bool."""
    visible = visibility(state.fit.poses, state.fit.cov, config.body_radius_m, config.least_visible)
    if is_there is not None:
        visible *= np.outer(is_there, is_there)
    candidates, counts, likelihoods = pair_likelihoods(
        state.fit.poses, state.fit.cov, problem.start, problem.bearings, problem.var,
        problem.known, state.seen, state.limit, visible, config.gate_sd, config.detected_share,
        config.num_false / (2.0 * np.pi),
    )  # fmt: skip
    sure = beliefs(candidates, counts, likelihoods, len(problem.bearings), config.num_messages)
    owner, belief = best_owners(candidates, counts, sure, len(problem.bearings))
    return replace(state, owner=owner, belief=belief)
