"""Robots that few others confirm, all at once: who stands at which place that nobody owns.

One that is in another's place keeps that one from being found, and any place near the middle of a
crowd finds a few bearings by chance. So none of them is looked for by itself: all are taken away,
places are looked for by the rest (`team_places`), and robots and places are assigned to each other
as a whole. Where the assignment leaves a doubt, a robot goes back to its rough pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit
from multi_localizer.team_identify import believe
from multi_localizer.team_places import known_robots, open_places
from multi_localizer.team_problem import TeamProblem
from multi_localizer.team_recovery import prior_distance, put, returned
from multi_localizer.team_relocate import MOST_PRIOR, nearest_table
from multi_localizer.team_seats import NEVER, seat_scores
from multi_localizer.team_state import Identification
from multi_localizer.team_trust import WRONG_PRIOR

_AROUND = 0.3  # m around the team
_REACH = 3.5  # deviations of a rough pose
_STEP = 0.1  # m, of the grid
_MOST_CELLS = 200_000  # of the grid; a larger area is looked at more coarsely
_THROWN = 20.0  # times the median distance from the middle
_APART = 0.2  # m
_SPARE = 3  # times as many places are looked at as robots are missing
_SPARE_MORE = 10
_BLUR = 0.02  # m, of a place
_CLEAR = 5.0  # log-likelihood by which a place must be better than the next
_SAME, _SAME_YAW = 0.05, 0.05  # m and rad: it is where it was
_LEAST_PLACED = 3
_AWAY = 1e3  # m


def reseat(
    problem: TeamProblem, found: Identification, lost: np.ndarray, config: TeamConfig
) -> tuple[Identification, np.ndarray]:
    """Look for robots anew, all at once.

    Args:
        problem: The views.
        found: Identities and poses so far.
        lost: Which robots, (N,) bool.
        config: Tuning.

    Returns:
        found: With new poses.
        moved: Which robots have one, (N,) bool.
    """
    moved = np.zeros(problem.num_robots, dtype=np.bool_)
    if not lost.any() or problem.num_robots - lost.sum() < _LEAST_PLACED:
        return found, moved
    x, cov = found.fit.poses.copy(), found.fit.cov.copy()
    weight = found.prior_weight.copy()
    who = np.flatnonzero(lost)
    places, scores, yaws = _seats(problem, found, lost, config)
    for a, p in zip(*linear_sum_assignment(scores, maximize=True), strict=True):
        u = int(who[a])
        if scores[a, p] <= NEVER:
            continue
        pose = np.array([*places[p, :2], yaws[a, p]])
        if problem.has_prior[u] and scores[a, p] - _rival(scores[a], p) < _CLEAR:
            x[u] = problem.prior[u]
            put(x, cov, u, problem.prior[u], np.linalg.inv(problem.prior_info[u]))
        elif _is_elsewhere(pose, x[u]):
            put(x, cov, u, pose)
        else:
            continue
        moved[u] = True
        is_wrong = prior_distance(problem, u, x[u]) > WRONG_PRIOR
        weight[u] = 0.0 if is_wrong else float(problem.has_prior[u])
    return replace(found, fit=TeamFit(x, cov, found.fit.cost), prior_weight=weight), moved


def _seats(
    problem: TeamProblem, found: Identification, lost: np.ndarray, config: TeamConfig
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places, (P, 3), and the score and yaw of each robot of `lost` at each, (W, P)."""
    x, cov, width = found.fit.poses, found.fit.cov, 2.0 * config.body_radius_m
    is_open = returned(problem, without_robots(problem, found, lost, config)) < 0
    table = nearest_table(problem.start, problem.bearings, np.ones_like(is_open))
    corners = _corners(problem, x[~lost, :2])
    hidden_rate = width / float(np.prod(corners[1] - corners[0]))
    around, reach = _around(problem, corners, lost)
    low, high = _area(corners, around, reach, config.far_sd_m)
    known = known_robots(x, cov, ~lost)
    arrays = (known, problem.bearings, problem.var, is_open, table)
    step = max(_STEP, float(np.sqrt(np.prod(high - low) / _MOST_CELLS)))
    places = open_places(
        low, high, step, _APART, _SPARE * int(lost.sum()) + _SPARE_MORE, around, reach,
        hidden_rate * problem.num_robots, config.detected_share, width, *arrays,
    )  # fmt: skip
    mark_start = np.searchsorted(problem.mark_robot, np.arange(problem.num_robots + 1))
    scores, yaws = seat_scores(
        np.flatnonzero(lost), places, problem.prior, problem.prior_info, problem.has_prior, _BLUR,
        hidden_rate * lost.sum(), config.detected_share, width, MOST_PRIOR, *arrays,
        mark_start, problem.mark_bearing, problem.mark_var, problem.marks,
        problem.kind_start[problem.mark_kind], problem.kind_start[problem.mark_kind + 1],
    )  # fmt: skip
    return places, scores, yaws


def _corners(problem: TeamProblem, known: np.ndarray) -> np.ndarray:
    """Return the corners of a box around known robots and landmarks, (2, 2), m.

    A robot that a fit has thrown far away from all others does not count.
    """
    places = np.vstack((known, problem.marks))
    off = np.hypot(*(places - np.median(places, axis=0)).T)
    places = places[off <= _THROWN * max(float(np.median(off)), _AROUND)]
    return np.vstack((places.min(axis=0) - _AROUND, places.max(axis=0) + _AROUND))


def _around(
    problem: TeamProblem, corners: np.ndarray, lost: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return disks where the lost robots may be, by their rough poses: middles and radii, m.

    If one has no rough pose it is one disk around the whole box.
    """
    if problem.has_prior[lost].all():
        sd = [np.sqrt(np.diag(np.linalg.inv(info))[:2].max()) for info in problem.prior_info[lost]]
        return problem.prior[lost, :2], _REACH * np.array(sd)
    half = 0.5 * float(np.hypot(*(corners[1] - corners[0])))
    return corners.mean(axis=0)[None], np.array([half])


def _area(
    corners: np.ndarray, around: np.ndarray, reach: np.ndarray, margin: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the box around disks, as far as it is near the box of the team."""
    low, high = (around - reach[:, None]).min(axis=0), (around + reach[:, None]).max(axis=0)
    limits = corners[0] - margin, corners[1] + margin
    return np.clip(low, *limits), np.clip(high, *limits)


def without_robots(
    problem: TeamProblem, found: Identification, lost: np.ndarray, config: TeamConfig
) -> Identification:
    """Return who is who if some robots, (N,) bool, were not there: nor would they hide anybody."""
    poses = found.fit.poses.copy()
    poses[lost, :2] += _AWAY * (1.0 + np.arange(lost.sum())[:, None])
    owners = np.repeat(np.arange(problem.num_robots), np.diff(problem.start))
    drop = lost[owners] | ((found.seen >= 0) & lost[found.seen])
    away = replace(
        found, seen=np.where(drop, -1, found.seen), fit=TeamFit(poses, found.fit.cov, 0.0)
    )
    return believe(problem, away, config, ~lost)


def _rival(scores: np.ndarray, chosen: int) -> float:
    others = np.delete(scores, chosen)
    return float(others.max()) if len(others) else NEVER


def _is_elsewhere(pose: np.ndarray, old: np.ndarray) -> bool:
    turn = abs((pose[2] - old[2] + np.pi) % (2.0 * np.pi) - np.pi)
    return bool(np.hypot(*(pose - old)[:2]) > _SAME or turn > _SAME_YAW)
