"""Identities by soft beliefs, then those robots anew that few others confirm: for hard cases.

Crowds, a third of all detections missing, rough poses worse than the gaps between robots: whoever
decides on the surest bearings first decides wrongly there, and builds on it. See `team_soft`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from multi_localizer.team_beliefs import beliefs
from multi_localizer.team_choice import best_owners
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import fit_poses
from multi_localizer.team_hiding import visibility
from multi_localizer.team_identify import place_first, refine
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_recovery import relocate_lost, returned_share
from multi_localizer.team_single import find_marks
from multi_localizer.team_soft import as_bearings, soft_likelihoods, update_aims
from multi_localizer.team_state import PLAIN, Identification

_COLD_AT = 0.8  # of the rounds
_INERTIA = 0.5
_MESSAGES = 6  # a round; the next one goes on
_STEPS = 3  # of the fit a round; likewise
_SURE = 0.9
_AGAIN = 8  # rounds after a search
_STRICTER = 0.15  # of the share that is asked for, every second search
_GAIN = 1.003
_SWAPPED = 0.2  # of the robots: if no more are left, they may be in each other's place
_PATIENCE = 3  # searches in vain


@dataclass(frozen=True, eq=False)
class _Aims:
    """Gaussian bearings of each robot to each other one: information (0 for none) and value."""

    info: np.ndarray
    aim: np.ndarray

    def forget(self, robots: np.ndarray) -> None:
        """Drop all of some robots and to them, (N,) bool."""
        self.info[robots, :] = 0.0
        self.info[:, robots] = 0.0


def settle_crowd(problem: TeamProblem, config: TeamConfig) -> Identification:
    """Return the identities of a team by soft beliefs.

    Args:
        problem: The views.
        config: Tuning.
    """
    size = (problem.num_robots, problem.num_robots)
    aims = _Aims(np.zeros(size), np.zeros(size))
    start = place_first(problem, problem.has_prior.astype(float), config)
    found = best = anneal(problem, start, aims, _heats(config), config)
    again = np.full(_AGAIN, config.soft_cold)
    num_vain = 0
    for k in range(config.crowd_searches):
        lost = _unconfirmed(problem, found, config.confirmed_share + _STRICTER * (k % 2))
        may_swap = len(lost) <= _SWAPPED * problem.num_robots
        if not len(lost):
            continue
        moved, num_moved = relocate_lost(problem, found, lost, may_swap=may_swap)
        if num_moved == 0:
            continue
        aims.forget((moved.fit.poses != found.fit.poses).any(axis=1))
        found = anneal(problem, moved, aims, again, config)
        before, now = returned_share(problem, best).sum(), returned_share(problem, found).sum()
        best = found if now > before else best
        num_vain = 0 if now > _GAIN * before else num_vain + 1
        if num_vain == _PATIENCE:
            break
    return refine(problem, best, config, config.search_rounds)


def _heats(config: TeamConfig) -> np.ndarray:
    """Return the heat of each round, (R,)."""
    fall = (config.soft_cold / config.soft_heat) ** (1.0 / (_COLD_AT * config.soft_rounds))
    heats = config.soft_heat * fall ** np.arange(config.soft_rounds)
    return np.maximum(heats, config.soft_cold)


def _unconfirmed(problem: TeamProblem, found: Identification, least: float) -> np.ndarray:
    """Return robots of whose bearings less than a share is returned, half of all, worst last."""
    share = returned_share(problem, found)
    worst = np.argsort(share, kind="stable")[: max(problem.num_robots // 2, 2)]
    return worst[share[worst] < least][::-1]


def anneal(
    problem: TeamProblem, state: Identification, aims: _Aims, heats: np.ndarray,
    config: TeamConfig,
) -> Identification:  # fmt: skip
    """Return identities and poses after a round of soft beliefs at each heat; `aims` go along."""
    fit = state.fit
    for heat in heats:
        visible = visibility(fit.poses, fit.cov, config.body_radius_m, config.least_visible)
        candidates, counts, likelihoods, expected, spread = soft_likelihoods(
            fit.poses, fit.cov, problem.start, problem.bearings, problem.var, problem.known,
            aims.info, aims.aim, heat, visible, config.gate_sd, config.detected_share,
            config.num_false / (2.0 * np.pi),
        )  # fmt: skip
        sure = beliefs(candidates, counts, likelihoods, len(problem.bearings), _MESSAGES)
        update_aims(
            aims.info, aims.aim, candidates, counts, sure, problem.bearings, problem.var, expected,
            spread, _INERTIA,
        )  # fmt: skip
        start, bearings, var, seen = as_bearings(aims.info, aims.aim)
        marks = find_marks(problem, fit, config)
        soft = replace(problem, start=start, bearings=bearings, var=var)
        fit = fit_poses(soft, fit.poses, seen, marks, state.prior_weight, PLAIN, _STEPS)
    owner, belief = best_owners(candidates, counts, sure, len(problem.bearings))
    seen = np.where(belief > _SURE, owner, -1)
    return replace(state, owner=owner, belief=belief, seen=seen, mark_seen=marks, fit=fit)
