"""Each robot by itself: from its rough pose and the landmarks it sees.

Close to a landmark a bearing to it is right at the one place or the other a few centimeters away:
the likelihood grows without bound towards the landmark, and a fit that gets there stays, sure of
itself. No robot's middle can be there. A landmark at which a robot by itself ends is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit, solve_each
from multi_localizer.team_marks import nearest_marks
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_state import PLAIN

_TOUCHING = 0.05  # m beyond the robot's radius
_STEPS = 30  # of a fit, at most
_NEAR_SD = 2.0  # deviations of the robot's place


def place_alone(problem: TeamProblem, mark_seen: np.ndarray, prior_weight: np.ndarray) -> TeamFit:
    """Return every robot's pose without the others.

    Args:
        problem: The views.
        mark_seen: Landmark of each bearing to one, (K,); -1 for none.
        prior_weight: What each rough pose counts, (N,).
    """
    mark_start = np.searchsorted(problem.mark_robot, np.arange(problem.num_robots + 1))
    x, cov, cost = solve_each(
        problem.prior, mark_start, problem.mark_bearing, problem.mark_var, problem.marks, mark_seen,
        problem.prior, problem.prior_info, prior_weight, PLAIN, _STEPS,
    )  # fmt: skip
    return TeamFit(x, cov, float(cost))


def find_marks(problem: TeamProblem, fit: TeamFit, config: TeamConfig) -> np.ndarray:
    """Return the landmark of each bearing to one, (K,); -1 for none."""
    return nearest_marks(
        fit.poses, fit.cov, problem.mark_robot, problem.mark_kind, problem.mark_bearing,
        problem.mark_var, problem.marks, problem.kind_start, config.gate_sd,
    )  # fmt: skip


def first_marks(problem: TeamProblem, prior_weight: np.ndarray, config: TeamConfig) -> np.ndarray:
    """Return the landmark of each bearing to one as the rough poses say, (K,); -1 for none."""
    no_mark = np.full(len(problem.mark_robot), -1, dtype=np.int64)
    return find_marks(problem, place_alone(problem, no_mark, prior_weight), config)


def without_touched_marks(problem: TeamProblem, config: TeamConfig) -> TeamProblem:
    """Return the problem without landmarks at which robots end by themselves."""
    weight = problem.has_prior.astype(float)
    mark_seen = first_marks(problem, weight, config)
    poses = place_alone(problem, mark_seen, weight).poses
    arm = problem.marks[mark_seen] - poses[problem.mark_robot, :2] if len(mark_seen) else None
    if arm is None:
        return problem
    near = (mark_seen >= 0) & (np.hypot(*arm.T) < config.body_radius_m + _TOUCHING)
    near &= problem.has_prior[problem.mark_robot]
    if not near.any():
        return problem
    notes = [
        f"{problem.names[problem.mark_robot[k]]}: too close to {problem.kinds[kind]} to use it"
        for k, kind in enumerate(problem.mark_kind)
        if near[k]
    ]
    return replace(
        problem,
        mark_robot=problem.mark_robot[~near],
        mark_kind=problem.mark_kind[~near],
        mark_source=problem.mark_source[~near],
        mark_bearing=problem.mark_bearing[~near],
        mark_var=problem.mark_var[~near],
        notes=(*problem.notes, *notes),
    )


def telling_marks(
    problem: TeamProblem, mark_seen: np.ndarray, prior_weight: np.ndarray
) -> np.ndarray:
    """Return landmarks without those so near that a robot alone may be on any side of them, (K,).

    Within two deviations of the robot's place the bearing's direction is not linear in it, and
    the covariance of a fit would be too small.
    """
    fit = place_alone(problem, np.full(len(mark_seen), -1, dtype=np.int64), prior_weight)
    var = np.diag(fit.cov).reshape(-1, 3)[problem.mark_robot]
    sd = np.sqrt(np.maximum(var[:, 0], var[:, 1]))
    arm = problem.marks[mark_seen] - fit.poses[problem.mark_robot, :2]
    is_near = np.hypot(arm[:, 0], arm[:, 1]) < _NEAR_SD * sd
    has_prior = problem.has_prior[problem.mark_robot]
    return np.where(is_near & has_prior, -1, mark_seen)
