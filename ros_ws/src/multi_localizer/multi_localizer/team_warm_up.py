"""Solves a small made-up team, so that all kernels of the solver are compiled before they count."""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_over_time import TeamOverTime
from multi_localizer.team_solver import solve_team
from multi_localizer.team_views import RobotView

_PLACES = np.array([[0.0, 0.0], [3.0, 0.5], [1.0, 2.5], [2.5, 3.5]])
_MARKS = np.array([[5.0, 0.0], [-2.0, 4.0]])


def warm_up(config: TeamConfig) -> None:
    """Compile: a team with landmarks and other things, and one of which little is known."""
    views, marks = [_view(i, has_all=True) for i in range(len(_PLACES))], {"mark": _MARKS}
    solution = solve_team(views, marks, config)
    over_time = TeamOverTime(solution.names, marks, TeamFilterConfig())
    for stamp_ns in range(1, 4):
        over_time.follow(stamp_ns, views, solution, lambda *_: SE2(0.01, 0.0, 0.01))
    solve_team([_view(i, has_all=False) for i in range(len(_PLACES))], {}, config)


def _view(i: int, *, has_all: bool) -> RobotView:
    others = np.delete(_PLACES, i, axis=0)
    x, y = _PLACES[i].tolist()
    rough = PoseEstimate(SE2(x + 0.05, y, 0.02), 0.1 * np.eye(3))
    if not has_all:
        return RobotView(f"r{i}", _bearings(i, others), rough=rough if i == 0 else None)
    marks = {"mark": _bearings(i, _MARKS)}
    things = {"thing": _bearings(i, np.array([[1.0, 1.0]]))}
    return RobotView(f"r{i}", _bearings(i, others), marks, things, rough)


def _bearings(i: int, places: np.ndarray) -> np.ndarray:
    x, y = (places - _PLACES[i]).T
    return np.asarray(np.arctan2(y, x))
