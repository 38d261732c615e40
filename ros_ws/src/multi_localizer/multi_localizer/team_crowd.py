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
from multi_localizer.team_fit import step_poses
from multi_localizer.team_hiding import visibility
from multi_localizer.team_identify import place_first, refine
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_recovery import relocate_lost, returned_share
from multi_localizer.team_reseat import reseat
from multi_localizer.team_single import find_marks
from multi_localizer.team_soft import as_bearings, soft_likelihoods, update_aims
from multi_localizer.team_state import PLAIN, Identification

_COLD_AT = 0.8  # of the rounds
_INERTIA = 0.5
_GATE = 0.75  # times the gate: of innovations that count as wider
_LOOKS = 4  # rounds for which it stands who hides whom
_MESSAGES = 6  # a round; the next one goes on
_SURE = 0.9
_AGAIN = 6  # rounds after a search
_STRICTER = 0.15  # of the share that is asked for, after a search in vain
_USUAL = 0.8  # of what the team's median robot has returned is enough
_LEAST_CONFIRMED = 0.4
SMALL_TEAM = 25  # robots
_PATIENCE = 6  # searches in vain
_LOSS = 2.0  # robots' bearings: if so much less is returned, what was before is gone on from


@dataclass(frozen=True, eq=False)
class _Aims:
    """Gaussian bearings of each robot to each other one: information (0 for none) and value."""

    info: np.ndarray
    aim: np.ndarray

    @classmethod
    def none(cls, num_robots: int) -> _Aims:
        """Return that nobody knows anything of anybody."""
        return cls(np.zeros((num_robots, num_robots)), np.zeros((num_robots, num_robots)))

    def copy(self) -> _Aims:
        """Return the same, to keep."""
        return _Aims(self.info.copy(), self.aim.copy())

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
    aims = _Aims.none(problem.num_robots)
    start = place_first(problem, problem.has_prior.astype(float), config)
    found = best = anneal(problem, start, aims, _heats(config), config)
    best_aims, num_vain = aims.copy(), 0
    again = np.full(_AGAIN, config.soft_cold)
    for _ in range(config.crowd_searches):
        lost = _unconfirmed(problem, found, config.confirmed_share + _STRICTER * (num_vain % 2))
        if num_vain == _PATIENCE:
            break
        moved, who = _search(problem, found, lost, num_vain, config)
        if not who.any():
            num_vain += 1
            continue
        aims.forget(who)
        found = anneal(problem, moved, aims, again, config)
        before, now = returned_share(problem, best).sum(), returned_share(problem, found).sum()
        num_vain = 0 if now > before else num_vain + 1
        if now > before:
            best, best_aims = found, aims.copy()
        elif now < before - _LOSS:
            found, aims = best, best_aims.copy()
    return refine(problem, best, config, config.search_rounds)


def _search(
    problem: TeamProblem, found: Identification, lost: np.ndarray, num_vain: int,
    config: TeamConfig,
) -> tuple[Identification, np.ndarray]:  # fmt: skip
    """Look for lost robots all at once; in a small team, if that was in vain, one after another."""
    if num_vain % 4 < 2 or problem.num_robots > SMALL_TEAM:
        return reseat(problem, found, lost, config)
    share = returned_share(problem, found)
    order = np.flatnonzero(lost)[np.argsort(-share[lost], kind="stable")]
    moved, _ = relocate_lost(problem, found, order)
    return moved, np.asarray((moved.fit.poses != found.fit.poses).any(axis=1))


def _heats(config: TeamConfig) -> np.ndarray:
    """Return the heat of each round, (R,)."""
    fall = (config.soft_cold / config.soft_heat) ** (1.0 / (_COLD_AT * config.soft_rounds))
    heats = config.soft_heat * fall ** np.arange(config.soft_rounds)
    return np.maximum(heats, config.soft_cold)


def _unconfirmed(problem: TeamProblem, found: Identification, least: float) -> np.ndarray:
    """Return robots of whose bearings less than a share is returned, half of all at most, (N,)."""
    share = returned_share(problem, found)
    worst = np.argsort(share, kind="stable")[: problem.num_robots // 2]
    lost = np.zeros(problem.num_robots, dtype=np.bool_)
    usual = max(_USUAL * float(np.median(share)), _LEAST_CONFIRMED)
    lost[worst[share[worst] < min(least, usual)]] = True
    return lost


def anneal(
    problem: TeamProblem, state: Identification, aims: _Aims, heats: np.ndarray,
    config: TeamConfig,
) -> Identification:  # fmt: skip
    """Return identities and poses after a round of soft beliefs at each heat; `aims` go along."""
    fit = state.fit
    for turn, heat in enumerate(heats):
        if turn % _LOOKS == 0:
            visible = visibility(fit.poses, fit.cov, config.body_radius_m, config.least_visible)
        candidates, counts, likelihoods, expected, spread = soft_likelihoods(
            fit.poses, fit.cov, problem.start, problem.bearings, problem.var, problem.known,
            aims.info, aims.aim, heat, visible, _GATE * config.gate_sd, config.detected_share,
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
        fit = step_poses(soft, fit.poses, seen, marks, state.prior_weight, PLAIN)
    owner, belief = best_owners(candidates, counts, sure, len(problem.bearings))
    seen = np.where(belief > _SURE, owner, -1)
    return replace(state, owner=owner, belief=belief, seen=seen, mark_seen=marks, fit=fit)
