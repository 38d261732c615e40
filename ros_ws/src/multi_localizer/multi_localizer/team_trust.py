"""What of an answer is to be believed: rough poses and robots that lie, answers that are chance.

In a crowd any bearing is near some robot: that it finds an owner proves little. But who sees is
seen. The share of bearings that have an owner, times the share of those that their owner returns,
is high if the identities are right, even with false and missing detections, and low by chance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_state import Identification

WRONG_PRIOR = 20.0  # squared deviations of a rough pose from where the robot is: it was wrong
_LEAST_MARKS = 2
_LEAST_VIEWS = 3  # bearings; of so few, liars' fit nobody at all
_MOST_NEEDED = 0.85
_MANY = 6  # bearings: of fewer, shares say little
_SPREAD = 3.0  # deviations by which fewer than usual may be returned
_CROWD_SPREAD = 2.0  # in a crowd, where chance returns more
_CROWD = 25  # robots
_LIKELY = 0.35  # of two robots in one direction either may be it


def contradicted_priors(problem: TeamProblem, alone: TeamFit, mark_seen: np.ndarray) -> np.ndarray:
    """Return which rough poses the robot's own landmarks contradict, (N,) bool."""
    num_marks = np.bincount(problem.mark_robot[mark_seen >= 0], minlength=problem.num_robots)
    e = alone.poses - problem.prior
    e[:, 2] = (e[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    squared = np.einsum("ni,nij,nj->n", e, problem.prior_info, e)
    return np.asarray((squared > WRONG_PRIOR) & (num_marks >= _LEAST_MARKS) & problem.has_prior)


def trust(problem: TeamProblem, found: Identification) -> float:
    """Return the share of bearings with an owner times the share that is returned, 0..1."""
    if not len(found.seen):
        return 1.0
    sees = _sees(problem, found)
    if not sees.any():
        return 0.0
    explained = float((found.belief > _LIKELY).mean())
    return explained * float((sees & sees.T).sum() / sees.sum())


def needed_trust(problem: TeamProblem, config: TeamConfig) -> float:
    """Return the trust below which identities may be chance.

    A bearing drawn at random is within two deviations of one of N - 1 robots with the chance
    1 - exp(-(N - 1) 4 sd / (2 pi)): the more robots and the more noise, the more is asked for.
    """
    if not len(problem.var):
        return 0.0
    width = 4.0 * float(np.sqrt(np.mean(problem.var))) / (2.0 * np.pi)
    chance = 1.0 - np.exp(-(problem.num_robots - 1) * width)
    return float(min(config.least_trust + 2.0 * chance, _MOST_NEEDED))


def doubted(problem: TeamProblem, found: Identification, config: TeamConfig) -> np.ndarray:
    """Return robots of whose bearings too few are returned, (N,) bool: they may be elsewhere."""
    sees = _sees(problem, found)
    returned = (sees & sees.T).sum(axis=1)
    counts = np.diff(problem.start)
    many = counts >= _MANY
    share = returned[many] / counts[many]
    usual = min(config.returned_share, float(np.median(share))) if many.any() else 0.0
    spread = _CROWD_SPREAD if problem.num_robots > _CROWD else _SPREAD
    least = usual * counts - spread * np.sqrt(usual * (1.0 - usual) * counts)
    return np.asarray(many & (returned < least))


def _sees(problem: TeamProblem, found: Identification) -> np.ndarray:
    """Return who counts as seeing whom, (N, N) bool."""
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    counts = found.seen >= 0
    sees = np.zeros((problem.num_robots, problem.num_robots), dtype=np.bool_)
    sees[owners[counts], found.seen[counts]] = True
    return sees


def liars(problem: TeamProblem, found: Identification, config: TeamConfig) -> np.ndarray:
    """Return which robots' bearings fit nobody, (N,) bool."""
    counts = np.diff(problem.start)
    owners = np.repeat(np.arange(problem.num_robots), counts)
    fitting = np.bincount(owners[found.seen >= 0], minlength=problem.num_robots)
    return np.asarray((counts >= _LEAST_VIEWS) & (fitting < config.liar_share * counts - 0.5))


def without(
    problem: TeamProblem, found: Identification, robots: np.ndarray, *, also_to: bool
) -> Identification:
    """Return identities without the bearings of some robots, (N,) bool, or also those to them."""
    drop = np.repeat(robots, np.diff(problem.start))
    if also_to:
        drop = drop | ((found.owner >= 0) & robots[found.owner])
    return replace(
        found,
        owner=np.where(drop, -1, found.owner),
        seen=np.where(drop, -1, found.seen),
        belief=np.where(drop, 0.0, found.belief),
    )
