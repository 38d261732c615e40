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

_WRONG_PRIOR = 20.0  # squared deviations of a rough pose from where landmarks put the robot
_LEAST_MARKS = 2


def contradicted_priors(problem: TeamProblem, alone: TeamFit, mark_seen: np.ndarray) -> np.ndarray:
    """Return which rough poses the robot's own landmarks contradict, (N,) bool."""
    num_marks = np.bincount(problem.mark_robot[mark_seen >= 0], minlength=problem.num_robots)
    e = alone.poses - problem.prior
    e[:, 2] = (e[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    squared = np.einsum("ni,nij,nj->n", e, problem.prior_info, e)
    return np.asarray((squared > _WRONG_PRIOR) & (num_marks >= _LEAST_MARKS) & problem.has_prior)


def trust(problem: TeamProblem, found: Identification) -> float:
    """Return the share of bearings with an owner times the share that is returned, 0..1."""
    if not len(found.seen):
        return 1.0
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    counts = found.seen >= 0
    sees = np.zeros((problem.num_robots, problem.num_robots), dtype=np.bool_)
    sees[owners[counts], found.seen[counts]] = True
    if not sees.any():
        return 0.0
    return float(counts.mean() * (sees & sees.T).sum() / sees.sum())


def liars(problem: TeamProblem, found: Identification, config: TeamConfig) -> np.ndarray:
    """Return which robots' bearings fit nobody, (N,) bool."""
    counts = np.diff(problem.start)
    owners = np.repeat(np.arange(problem.num_robots), counts)
    fitting = np.bincount(owners[found.seen >= 0], minlength=problem.num_robots)
    return np.asarray((counts >= 4) & (fitting < config.liar_share * counts))


def without(problem: TeamProblem, found: Identification, robots: np.ndarray) -> Identification:
    """Return identities without the bearings of some robots, (N,) bool."""
    drop = np.repeat(robots, np.diff(problem.start))
    return replace(
        found,
        owner=np.where(drop, -1, found.owner),
        seen=np.where(drop, -1, found.seen),
        belief=np.where(drop, 0.0, found.belief),
    )
