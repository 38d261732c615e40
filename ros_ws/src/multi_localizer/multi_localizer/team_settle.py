"""Identities and poses; robots are looked for anew until every view is explained or none better."""

from __future__ import annotations

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_crowd import SMALL_TEAM, settle_crowd
from multi_localizer.team_identify import identify, refine
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_recovery import explained_share, relocate_lost
from multi_localizer.team_state import Identification
from multi_localizer.team_told import take_told
from multi_localizer.team_trust import doubted, trust

_CROWD = 150  # bearings: of more, robots are looked for by soft beliefs only
_TRUSTED = 0.9
_GAIN = 1.003
_ENOUGH = 0.98  # share of the bearings that is explained if all went well


def settle(problem: TeamProblem, config: TeamConfig) -> Identification:
    """Identify from rough poses, then look for robots that do not fit, again and again.

    In a large team that goes wrong somewhere for sure, so soft beliefs begin. In a small one they
    come second, if too much is left unexplained: they cost more time. The answer that explains
    more, and confirms it from both ends, counts.

    Args:
        problem: The views.
        config: Tuning.
    """
    told = take_told(problem, config)
    if told is not None:
        return told
    if problem.num_robots > SMALL_TEAM:
        return _searched(problem, settle_crowd(problem, config), config)
    found = identify(problem, problem.has_prior.astype(float), config)
    if len(problem.bearings) <= _CROWD or _is_settled(problem, found, config):
        found = _searched(problem, found, config)
    if _is_settled(problem, found, config):
        return found
    other = _searched(problem, settle_crowd(problem, config), config)
    return other if trust(problem, other) > trust(problem, found) else found


def _is_settled(problem: TeamProblem, found: Identification, config: TeamConfig) -> bool:
    is_explained = num_explained(found) >= _ENOUGH * len(problem.bearings)
    if not is_explained or trust(problem, found) < _TRUSTED:
        return False
    return not bool(doubted(problem, found, config).any())


def _searched(problem: TeamProblem, found: Identification, config: TeamConfig) -> Identification:
    """Return the best of what comes of looking for robots that do not fit, again and again."""
    best = found
    for _ in range(config.max_searches):
        share = explained_share(problem, found)
        has_views = np.diff(problem.start) >= config.least_views
        lost = np.flatnonzero((share < config.explained_share) & has_views)
        if not len(lost):
            break
        found, num_moved = relocate_lost(problem, found, _order(lost, share, config))
        if num_moved == 0:
            break
        found = refine(problem, found, config, config.search_rounds)
        is_better = num_explained(found) > num_explained(best)
        is_much = num_explained(found) > num_explained(best) * _GAIN
        best = found if is_better else best
        if len(problem.bearings) > _CROWD and not is_much:
            break
    return best


def _order(lost: np.ndarray, share: np.ndarray, config: TeamConfig) -> np.ndarray:
    """Return the robots to look for: the worst ones if there are many, the best of them first."""
    worst_first = lost[np.argsort(share[lost], kind="stable")][: config.max_lost]
    return worst_first[::-1]


def num_explained(found: Identification) -> float:
    """Return how many bearings are believed to be somebody's."""
    return float(found.belief[found.belief > 0.6].sum())
