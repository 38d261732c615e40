"""Other things located from the bearings of two and more robots (the team paper's next step).

Of each class, rays of two robots that cross ahead of both start a thing; every robot then gives the
ray that fits best, and the thing's place is their weighted least squares. The thing that explains
most rays takes them, and the rest is looked at again. A bearing's variance holds what the robot's
own pose is known by, the robots' joint covariance included: rays of robots whose poses err together
are not taken for independent ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from multi_localizer.rays import crossing
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_views import ObjectEstimate, RobotView, TeamSolution

_LEAST_CROSSING = 0.05  # sine of the angle; rays nearer to parallel say nothing of where they meet
_STEPS = 5


@dataclass(frozen=True, eq=False)
class _Rays:
    """Rays of one class.

    Attributes:
        robot: Index of the robot in `TeamSolution.estimates`, (R,).
        origin: (R, 2), m.
        yaw: Direction in the map, (R,), rad.
        var: Of the bearing alone, (R,), rad^2.
    """

    robot: np.ndarray
    origin: np.ndarray
    yaw: np.ndarray
    var: np.ndarray


def locate_objects(
    views: Sequence[RobotView], solution: TeamSolution, config: TeamConfig
) -> tuple[ObjectEstimate, ...]:
    """Locate what two or more robots with known poses see, class by class.

    Args:
        views: With `object_bearings`.
        solution: Poses of the robots with their joint covariance.
        config: Tuning.
    """
    kinds = sorted({kind for view in views for kind in view.object_bearings})
    found: list[ObjectEstimate] = []
    for kind in kinds:
        rays = _rays(kind, views, solution, config)
        left = np.ones(len(rays.robot), dtype=np.bool_)
        while left.sum() > 1:
            best = _best_object(rays, left, solution, config)
            if best is None:
                break
            place, cov, used = best
            left[used] = False
            names = list(solution.estimates)
            seen_by = tuple(names[rays.robot[k]] for k in used)
            found.append(ObjectEstimate(kind, place, cov, seen_by))
    return tuple(found)


def _rays(
    kind: str, views: Sequence[RobotView], solution: TeamSolution, config: TeamConfig
) -> _Rays:
    names = list(solution.estimates)
    rows = []
    for view in views:
        if view.name not in solution.estimates or view.name in solution.suspects:
            continue
        pose = solution.estimates[view.name].pose
        sd = config.bearing_sd_rad if view.bearing_sd is None else view.bearing_sd
        rows += [
            (names.index(view.name), pose.x, pose.y, pose.yaw + bearing, sd**2)
            for bearing in view.object_bearings.get(kind, ())
            if np.isfinite(bearing)
        ]
    table = np.array(rows).reshape(-1, 5)
    return _Rays(table[:, 0].astype(np.int64), table[:, 1:3], table[:, 3], table[:, 4])


def _best_object(
    rays: _Rays, left: np.ndarray, solution: TeamSolution, config: TeamConfig
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return place, covariance and rays of the thing that explains most rays; None for none."""
    best, best_score = None, -np.inf
    for a, b in combinations(np.flatnonzero(left), 2):
        if rays.robot[a] == rays.robot[b]:
            continue
        place = crossing(rays.origin[a], rays.yaw[a], rays.origin[b], rays.yaw[b], _LEAST_CROSSING)
        if place is None:
            continue
        used = _supporters(rays, left, place, solution, config)
        if len(used) < 2:
            continue
        place, cov, squared = _least_squares(rays, used, place, solution)
        score = len(used) * config.gate_sd**2 - squared
        is_good = squared <= config.gate_sd**2 * len(used)
        if is_good and np.isfinite(cov).all() and score > best_score:
            best, best_score = (place, cov, used), score
    if best is None or np.max(np.diag(best[1])) > config.far_sd_m**2:
        return None
    return best


def _residuals(rays: _Rays, used: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return bearing residuals, (U,), and their derivatives by the place, (U, 2)."""
    arm = place - rays.origin[used]
    squared = np.maximum((arm**2).sum(axis=1), 1e-4)
    e = rays.yaw[used] - np.arctan2(arm[:, 1], arm[:, 0])
    e = (e + np.pi) % (2.0 * np.pi) - np.pi
    return e, np.column_stack((arm[:, 1], -arm[:, 0])) / squared[:, None]


def _covariance(
    rays: _Rays, used: np.ndarray, by_place: np.ndarray, solution: TeamSolution
) -> np.ndarray:
    """Return the residuals' covariance, (U, U): bearings, and poses with their joint covariance."""
    columns = 3 * len(solution.estimates)
    J = np.zeros((len(used), columns))
    for row, k in enumerate(used):
        at = 3 * rays.robot[k]
        J[row, at : at + 2] = -by_place[row]
        J[row, at + 2] = 1.0
    joint = np.eye(columns) * 0.0 if solution.joint_cov is None else solution.joint_cov
    return np.asarray(J @ joint @ J.T + np.diag(rays.var[used]))


def _supporters(
    rays: _Rays, left: np.ndarray, place: np.ndarray, solution: TeamSolution, config: TeamConfig
) -> np.ndarray:
    """Return the rays that lead to a place within the gate, one of each robot at most."""
    candidates = np.flatnonzero(left)
    e, by_place = _residuals(rays, candidates, place)
    var = np.diag(_covariance(rays, candidates, by_place, solution))
    squared = e * e / var
    chosen: dict[int, int] = {}
    for at in np.argsort(squared):
        if squared[at] <= config.gate_sd**2:
            chosen.setdefault(int(rays.robot[candidates[at]]), int(candidates[at]))
    return np.array(sorted(chosen.values()), dtype=np.int64)


def _least_squares(
    rays: _Rays, used: np.ndarray, place: np.ndarray, solution: TeamSolution
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return place, covariance and squared residuals in deviations of the rays' crossing."""
    for _ in range(_STEPS):
        e, by_place = _residuals(rays, used, place)
        info = np.linalg.inv(_covariance(rays, used, by_place, solution))
        H = by_place.T @ info @ by_place
        if np.linalg.cond(H) > 1e12:
            return place, np.full((2, 2), np.inf), np.inf
        place = place - np.linalg.solve(H, by_place.T @ info @ e)
    e, by_place = _residuals(rays, used, place)
    info = np.linalg.inv(_covariance(rays, used, by_place, solution))
    cov = np.linalg.inv(by_place.T @ info @ by_place)
    return place, 0.5 * (cov + cov.T), float(e @ info @ e)
