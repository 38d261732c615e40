"""Teams that say whom they see: nothing is to be identified, only to be fitted and checked."""

from __future__ import annotations

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import fit_poses
from multi_localizer.team_identify import place_first
from multi_localizer.team_problem import UNKNOWN, TeamProblem
from multi_localizer.team_single import find_marks
from multi_localizer.team_state import Identification


def take_told(problem: TeamProblem, config: TeamConfig) -> Identification | None:
    """Return the poses by the names that came with all bearings.

    None if a bearing has no name or a robot no rough pose to start from, or if a bearing lies
    beyond the gate then: a name may be wrong, or the fit ended elsewhere.

    Args:
        problem: The views.
        config: Tuning.
    """
    seen = problem.known
    if not len(seen) or (seen == UNKNOWN).any() or not problem.has_prior.all():
        return None
    first = place_first(problem, problem.has_prior.astype(float), config)
    weight, marks = first.prior_weight, first.mark_seen
    fit = fit_poses(problem, first.fit.poses, seen, marks, weight, config.gate_sd)
    again = find_marks(problem, fit, config)
    if (again != marks).any():
        marks = again
        fit = fit_poses(problem, fit.poses, seen, marks, weight, config.gate_sd)
    if np.max(_squared_deviations(problem, fit.poses, seen)) > config.gate_sd**2:
        return None
    belief = (seen >= 0).astype(float)
    return Identification(seen, belief, seen, marks, weight, fit, config.gate_sd)


def _squared_deviations(problem: TeamProblem, poses: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the squared deviations of all bearings from where the fit has their owners, (M,)."""
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    arm = poses[seen, :2] - poses[owners, :2]
    e = problem.bearings + poses[owners, 2] - np.arctan2(arm[:, 1], arm[:, 0])
    e = (e + np.pi) % (2.0 * np.pi) - np.pi
    return np.where(seen >= 0, e * e / problem.var, 0.0)
