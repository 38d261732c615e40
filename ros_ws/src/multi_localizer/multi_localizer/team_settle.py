"""Identities and poses; robots are looked for anew until every view is explained or none better."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_identify import identify, refine
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_recovery import explained_share, relocate_lost
from multi_localizer.team_state import Identification
from multi_localizer.team_trust import needed_trust, trust

_MANY = 700  # bearings: of more, a search that gains little is the last
_HOPELESS = 0.1  # so far below the trust needed no search for single robots helps
_ENOUGH = 0.98  # share of the bearings that is explained if all went well
_GAIN = 1.003


def settle(problem: TeamProblem, config: TeamConfig) -> Identification:
    """Identify from rough poses, then look for robots that do not fit, again and again.

    If that leaves too much unexplained, once more in smaller steps and without settling yaws first:
    another way through what is ambiguous. The answer that explains more counts.

    Args:
        problem: The views.
        config: Tuning.
    """
    found = _settle_once(problem, config)
    num = len(problem.bearings)
    if num > _MANY or num_explained(found) >= _ENOUGH * num:
        return found
    slower = replace(config, loose_yaw_rad=np.pi, new_share=0.5 * config.new_share)
    other = _settle_once(problem, slower)
    return other if num_explained(other) > num_explained(found) else found


def _settle_once(problem: TeamProblem, config: TeamConfig) -> Identification:
    found = identify(problem, problem.has_prior.astype(float), config)
    best = found
    is_large = len(problem.bearings) > _MANY
    if is_large and trust(problem, found) < needed_trust(problem, config) - _HOPELESS:
        return found
    for _ in range(config.max_searches):
        share = explained_share(problem, found)
        has_views = np.diff(problem.start) >= config.least_views
        lost = np.flatnonzero((share < config.explained_share) & has_views)
        if not len(lost):
            break
        found, num_moved = relocate_lost(problem, found, _order(lost, share, config), config)
        if num_moved == 0:
            break
        found = refine(problem, found, config, config.search_rounds)
        is_better = num_explained(found) > num_explained(best)
        is_much = num_explained(found) > num_explained(best) * _GAIN
        best = found if is_better else best
        if is_large and not is_much:
            break
    return best


def _order(lost: np.ndarray, share: np.ndarray, config: TeamConfig) -> np.ndarray:
    """Return the robots to look for: the worst ones if there are many, the best of them first."""
    worst_first = lost[np.argsort(share[lost], kind="stable")][: config.max_lost]
    return worst_first[::-1]


def num_explained(found: Identification) -> float:
    """Return how many bearings are believed to be somebody's."""
    return float(found.belief[found.belief > 0.6].sum())
