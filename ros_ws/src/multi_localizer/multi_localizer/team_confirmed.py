"""Whether a robot's pose is held up by what is seen: only then is it said.

Of few bearings nearly all must fit somebody, or the robot may be elsewhere or make them up: one
fits by chance often enough, and in a small team there is nobody else to ask.

What a suspect sends is not believed until its teammates have said where it stands: the bearings
that they have of it, of those that it returns, must cross at one place, and at the pose found for
it. Its yaw, which nobody else can see, counts if nearly all that it sees agrees there: one bearing
can always be turned to fit, and of three drawn at random two often do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

_WORST_SD_M = 0.5  # along the axis known worst; rays nearer to parallel confirm nothing
_FEWEST_FITTING = 3  # one is used up by the yaw, one fits by chance
_LEAST_FITTING = 0.75  # share
_FEW = 6  # bearings to robots: of as many, a wrong pose makes a suspect


def is_confirmed(
    solution: TeamSolution, views: Sequence[RobotView], name: str, config: TeamConfig,
    num_away: int = 0,
) -> bool:  # fmt: skip
    """Return whether a robot's pose may be said: what it sees fits, a suspect's the others confirm.

    Args:
        solution: All poses and identities.
        views: What they were made of.
        name: Of the robot.
        config: As in `solve_team`.
        num_away: Robots of the team that have no view. They, and those that see nobody, may be
            seen, and that bearing is nobody's.
    """
    if name not in solution.estimates:
        return False
    fitting, total = _fitting(solution, name)
    if name not in solution.suspects:
        is_many = len(solution.identities.get(name, ())) >= _FEW
        num_silent = num_away + sum(not len(view.bearings) for view in views if view.name != name)
        return is_many or fitting >= _LEAST_FITTING * (total - num_silent)
    fix = _crossing(solution, views, name, config)
    if fix is None:
        return False
    place, cov = fix
    pose = solution.estimates[name].pose
    off = np.array([pose.x, pose.y]) - place
    is_there = float(off @ np.linalg.solve(cov, off)) <= config.gate_sd**2
    return is_there and fitting >= _FEWEST_FITTING and fitting >= _LEAST_FITTING * total


def _crossing(
    solution: TeamSolution, views: Sequence[RobotView], name: str, config: TeamConfig
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return where the rays of teammates meet that the robot returns, and its covariance."""
    me = solution.names.index(name)
    pose = solution.estimates[name].pose
    returned = {solution.names[k] for k in solution.identities[name] if k != NOBODY}
    info, about, num_rays = np.zeros((2, 2)), np.zeros(2), 0
    for view in views:
        is_good = view.name in returned and view.name in solution.estimates
        if not is_good or view.name in solution.suspects:
            continue
        mate = solution.estimates[view.name]
        sd = config.bearing_sd_rad if view.bearing_sd is None else view.bearing_sd
        origin = np.array([mate.pose.x, mate.pose.y])
        for bearing in np.asarray(view.bearings)[solution.identities[view.name] == me]:
            yaw = mate.pose.yaw + float(bearing)
            aside = np.array([-np.sin(yaw), np.cos(yaw)])
            far = float(np.hypot(pose.x - origin[0], pose.y - origin[1]))
            by_pose = np.array([aside[0], aside[1], far])  # moves the ray aside at the robot
            var = far**2 * sd**2 + float(by_pose @ mate.cov @ by_pose)
            info += np.outer(aside, aside) / var
            about += aside * float(aside @ origin) / var
            num_rays += 1
    if num_rays < 2 or np.linalg.eigvalsh(info)[0] < 1.0 / _WORST_SD_M**2:
        return None
    return np.linalg.solve(info, about), np.linalg.inv(info)


def _fitting(solution: TeamSolution, name: str) -> tuple[int, int]:
    """Return how many of the bearings that a robot has, to robots and landmarks, fit; of all."""
    none = np.zeros(0, dtype=np.int64)
    whose = [
        solution.identities.get(name, none),
        *solution.landmark_identities.get(name, {}).values(),
    ]
    identities = np.concatenate([np.asarray(ids) for ids in whose])
    return int(np.count_nonzero(identities != NOBODY)), len(identities)
