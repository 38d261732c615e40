"""What the bearings of a team cannot tell, found in the covariance and said in words.

Every pose carries a prior of 1 km and 100 rad only to keep the equations regular. A direction of
the poses that no measurement touches keeps that deviation: the null space. Mutual bearings alone
leave the whole team's place, turn and size open (four directions); robots in one line seen by
nobody from aside leave the distances along it open, too.
"""

from __future__ import annotations

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_state import Identification


def unknown_poses(fit: TeamFit, config: TeamConfig) -> np.ndarray:
    """Return which robots' poses are not determined, (N,) bool."""
    var = np.diag(fit.cov).reshape(-1, 3)
    is_far = np.max(var[:, :2], axis=1) > config.far_sd_m**2
    return is_far | (var[:, 2] > config.lost_yaw_rad**2) | ~np.isfinite(var).all(axis=1)


def words(problem: TeamProblem, fit: TeamFit, found: Identification, unknown: np.ndarray) -> str:
    """Return what is not determined, in words; "" if every pose is."""
    if not unknown.any():
        return ""
    names = ", ".join(name for name, is_lost in zip(problem.names, unknown, strict=True) if is_lost)
    reasons = _open_directions(problem, fit, found)
    return f"no pose of {names}: " + (", ".join(reasons) or "too little sees or is seen")


def _open_directions(problem: TeamProblem, fit: TeamFit, found: Identification) -> list[str]:
    """Return which of place, turn and size of the whole team nothing fixes."""
    places = fit.poses[:, :2]
    center = places.mean(axis=0)
    arm = places - center
    moves = {
        "place": _stack(np.tile([1.0, 0.0], (len(arm), 1)), 0.0),
        "turn": _stack(np.column_stack((-arm[:, 1], arm[:, 0])), 1.0),
        "size": _stack(arm, 0.0),
    }
    has_prior = found.prior_weight > 0.0
    num_marks = np.bincount(
        problem.mark_robot[found.mark_seen >= 0], minlength=problem.num_robots
    ).sum()
    if has_prior.any() or num_marks == 0 and _is_fixed(fit, moves["place"]):
        return []
    return [
        f"nothing tells the team's {word}"
        for word, move in moves.items()
        if not _is_fixed(fit, move)
    ]


def _stack(shift: np.ndarray, turn: float) -> np.ndarray:
    return np.column_stack((shift, np.full(len(shift), turn))).ravel()


def _is_fixed(fit: TeamFit, move: np.ndarray) -> bool:
    """Return whether a motion of all poses at once is determined to a few of its lengths."""
    length = float(move @ move)
    return length == 0.0 or float(move @ fit.cov @ move) / length**2 < 4.0
