"""Poses of a team as published (team paper, 3.2.3 and 3.3).

The relative layout is turned by the heading of the base robot, the one whose own pose is best, and
set on its place; its size comes from the landmarks. Each robot lies on the circle from which the
two landmarks appear under the angle that it sees, and on the ray along which the base robot sees
it: where they meet is its distance SL_i. The size is the mean of SL_i / SL_i^R, the distances in
the layout, of the robots that the base robot sees. Not in the paper: which pose is best (here: the
one with the least covariance), any covariance (here: that of the base robot's pose and of the
spread of the ratios), and when the result is refused: here if the ratios scatter, if it contradicts
the own poses of half the robots or more, and a robot whose place is known worse than `far_sd_m`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis
from multi_localizer.relative_layout import RelativeLayout, grow
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_problem import TeamProblem, make_problem, to_views
from multi_localizer.team_views import RobotView, TeamSolution, view_problem
from multi_localizer.two_landmarks import circle_distance, two_landmarks

_LEAST_ROBOTS = 3
_MOST_SCATTER = 0.5  # of the size: then a ray met another circle, or belongs to another robot
_UNKNOWN_SIZE = 1.0  # share of itself: one ratio alone tells nothing of its spread


def solve_published(
    views: Sequence[RobotView],
    landmarks: Mapping[str, np.ndarray],
    config: TeamConfig | None = None,
) -> TeamSolution:
    """Tell who is who and where the robots are by the published steps; see `solve_team`."""
    config = TeamConfig() if config is None else config
    names = tuple(view.name for view in views)
    problem_text = view_problem(views)
    if not problem_text and len(views) < _LEAST_ROBOTS:
        problem_text = f"{len(views)} robots make no triangle"
    if problem_text:
        return TeamSolution(names, problem=problem_text)
    problem = make_problem(views, landmarks, config)
    layout = None
    for grown in grow(problem, config.published.angle_tolerance_rad):
        layout = grown
    if layout is None:
        return TeamSolution(names, problem="no triangle holds", notes=problem.notes)
    return _placed(problem, views, layout, config)


def _placed(
    problem: TeamProblem, views: Sequence[RobotView], layout: RelativeLayout,
    config: TeamConfig,
) -> TeamSolution:  # fmt: skip
    """Set the layout on the field (3.3)."""
    relative = TeamSolution(
        names=problem.names,
        identities=to_views(problem, views, layout.owner),
        relative={problem.names[i]: _pose(layout, i) for i in layout.robots},
        notes=problem.notes,
        num_triangles=layout.num_triangles,
    )
    known = [i for i in layout.robots if problem.has_prior[i]]
    if not known:
        return replace(relative, unobservable="no robot knows its own pose: place and turn")
    cov = {i: np.linalg.inv(problem.prior_info[i]) for i in known}
    base = min(known, key=lambda i: float(np.trace(cov[i][:2, :2])))
    ratios = size_ratios(problem, layout, base)
    if not len(ratios):
        return replace(relative, unobservable="no robot sees two landmarks: the team's size")
    size = float(ratios.mean())
    scatter = float(ratios.std(ddof=1)) if len(ratios) > 1 else _UNKNOWN_SIZE * size
    if len(ratios) > 1 and scatter > _MOST_SCATTER * size:
        return replace(relative, unobservable="two landmarks do not agree on the team's size")
    spread = scatter / np.sqrt(len(ratios))
    placed = {
        i: _estimate(problem, layout, base, i, size, spread, cov[base]) for i in layout.robots
    }
    wrong = {i for i in known if _contradicts(problem, i, placed[i], cov[i], config)}
    if 2 * len(wrong) >= len(known):
        return replace(relative, unobservable="the layout contradicts the robots' own poses")
    return _said(problem, relative, placed, wrong, config)


def _said(
    problem: TeamProblem, relative: TeamSolution, placed: dict[int, PoseEstimate], wrong: set[int],
    config: TeamConfig,
) -> TeamSolution:  # fmt: skip
    """Return the answer with those poses that are known well enough and contradict nobody's."""
    return replace(
        relative,
        estimates={
            problem.names[i]: estimate
            for i, estimate in placed.items()
            if i not in wrong and np.max(np.diag(estimate.cov)[:2]) <= config.far_sd_m**2
        },
        suspects=tuple(problem.names[i] for i in sorted(wrong)),
    )


def _contradicts(
    problem: TeamProblem, i: int, placed: PoseEstimate, own_cov: np.ndarray, config: TeamConfig
) -> bool:
    own = PoseEstimate(SE2(*(float(value) for value in problem.prior[i])), own_cov)
    return mahalanobis(own, placed) > config.gate_sd**2


def size_ratios(problem: TeamProblem, layout: RelativeLayout, base: int) -> np.ndarray:
    """Return SL_i / SL_i^R of every robot that the base robot sees, if its circle is met."""
    place = problem.prior[base, :2]
    first, last = problem.start[base], problem.start[base + 1]
    rays = {int(layout.owner[k]): k for k in range(first, last)}
    ratios = []
    for i in layout.robots:
        seen = two_landmarks(problem, i) if i in rays else None
        if seen is None:
            continue
        arm = layout.places[i] - layout.places[base]
        along = float(problem.prior[base, 2] + problem.bearings[rays[i]])
        rough = problem.prior[i, :2] if problem.has_prior[i] else None
        far = circle_distance(place, along, seen, rough)
        if far is not None:
            ratios.append(far / float(np.hypot(*arm)))
    return np.array(ratios)


def _estimate(
    problem: TeamProblem, layout: RelativeLayout, base: int, i: int, size: float, spread: float,
    base_cov: np.ndarray,
) -> PoseEstimate:  # fmt: skip
    """Turn, stretch and move robot i's place in the layout (Fig. 6)."""
    turn = problem.prior[base, 2] - layout.yaws[base]
    c, s = np.cos(turn), np.sin(turn)
    arm = np.array([[c, -s], [s, c]]) @ (layout.places[i] - layout.places[base])
    place = problem.prior[base, :2] + size * arm
    by_base = np.array([[1.0, 0.0, -size * arm[1]], [0.0, 1.0, size * arm[0]], [0.0, 0.0, 1.0]])
    cov = by_base @ base_cov @ by_base.T
    cov[:2, :2] += spread**2 * np.outer(arm, arm)
    own = float(np.mean(problem.var)) if len(problem.var) else 0.0
    cov += own * np.diag([float(size**2 * arm @ arm), float(size**2 * arm @ arm), 1.0])
    yaw = wrap_angle(float(layout.yaws[i] + turn))
    return PoseEstimate(SE2(float(place[0]), float(place[1]), yaw), cov)


def _pose(layout: RelativeLayout, i: int) -> SE2:
    x, y = layout.places[i]
    return SE2(float(x), float(y), float(layout.yaws[i]))
