"""Where a robot starts: its pose from bearings alone, gathered while it drives.

One look through a narrow camera fits many places: the robot is on a circle through two landmarks,
or further away. So looks are gathered along the odometry's way until they fit one place and no
other: all poses of a grid around the landmarks are tried, the best are refined by least squares,
and the best of those is taken only if it is well determined and the others are unlikely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_start_kernels import (
    NUM_UNKNOWNS,
    WORST,
    cell_costs,
    cost_of,
    refined,
)

_NUM_YAWS = 36
_NUM_REFINED = 24
_MAX_CLUES = 60
_MAX_GRID_CLUES = 24
_SAME_M = 0.3
_SAME_RAD = 0.2
_MAX_YAW_SD = 0.2
_FITTING = 0.25
"""Share of the worst cost below which a place fits at all."""


@dataclass(frozen=True, eq=False)
class Clue:
    """One angle that says something about where a robot is.

    Attributes:
        stamp_ns: When.
        T_odom_base: The robot's pose then, by its odometry.
        way: Meters driven by then.
        turned: Radians turned by then, either way.
        angle: The bearing of a thing from the robot, or, if `is_seen`, the direction in the map in
            which a located teammate saw the robot; rad.
        var: Variance of the angle, rad^2.
        points: Where in the map the thing may be, or the teammate is, shape (P, 2), m.
        point_var: Variance of that position, m^2.
        is_seen: Whether the robot was seen by a teammate.
    """

    stamp_ns: int
    T_odom_base: SE2
    way: float
    turned: float
    angle: float
    var: float
    points: np.ndarray
    point_var: float = 0.0
    is_seen: bool = False


@dataclass(frozen=True)
class Driven:
    """Where the odometry says a robot is, and how far it came.

    Attributes:
        T_odom_base: Its pose.
        way: Meters driven in all.
        turned: Radians turned in all, either way.
    """

    T_odom_base: SE2
    way: float = 0.0
    turned: float = 0.0

    def moved(self, motion: SE2) -> Driven:
        """Return it after a motion."""
        way, turned = self.way + motion.distance, self.turned + abs(motion.yaw)
        return Driven(self.T_odom_base @ motion, way, turned)


def find_start(
    clues: Sequence[Clue], now: Driven, middle: np.ndarray, config: TeamFilterConfig
) -> PoseEstimate | None:
    """Return where a robot is now, or None while its clues do not tell.

    Args:
        clues: What it saw, and who saw it; of the last `start_window_s`.
        now: Its odometry now.
        middle: Landmarks of the map, shape (L, 2); the start is looked for around them.
        config: Noise, grid and what counts as sure.
    """
    if len(clues) < config.start_bearings:
        return None
    data = _arrays(clues, now, config)
    prior = np.zeros(NUM_UNKNOWNS)
    prior[3] = 1.0 / max(config.offset_sd_rad, 1e-4) ** 2
    prior[4] = 1.0 / max(config.turn_scale_sd, 1e-4) ** 2
    fits = [_refined(cell, data, prior) for cell in _best_cells(data, middle, config)]
    found = sorted((fit for fit in fits if fit is not None), key=lambda fit: fit[0])
    if not found or found[0][0] > _FITTING * WORST * len(data[0]):
        return None
    cost, place, cov = found[0]
    others = [fit[0] for fit in found[1:] if not _is_same(fit[1], place)]
    if others and min(others) - cost < 2.0 * np.log(config.start_odds):
        return None
    if np.sqrt(cov[0, 0] + cov[1, 1]) > config.start_max_sd_m or cov[2, 2] > _MAX_YAW_SD**2:
        return None
    return PoseEstimate(SE2(float(place[0]), float(place[1]), float(place[2])), cov[:3, :3])


_Data = tuple[np.ndarray, np.ndarray, np.ndarray]


def _arrays(clues: Sequence[Clue], now: Driven, config: TeamFilterConfig) -> _Data:
    """Return clues, points and the end of each clue's points, for the kernels."""
    kept = [clues[k] for k in np.unique(np.linspace(0, len(clues) - 1, _MAX_CLUES).astype(int))]
    rows = []
    for clue in kept:
        then = now.T_odom_base.between(clue.T_odom_base)
        way, turned = now.way - clue.way, now.turned - clue.turned
        yaw_var = config.turn_noise_way**2 * way + config.turn_noise**2 * turned
        xy_var = config.travel_noise**2 * way + clue.point_var + yaw_var * then.distance**2 / 3.0
        row = [then.x, then.y, then.yaw, clue.angle, clue.var, xy_var, yaw_var, clue.is_seen]
        rows.append([float(value) for value in row])
    ends = np.cumsum([len(clue.points) for clue in kept])
    return np.array(rows), np.concatenate([clue.points for clue in kept]), ends


def _thinned(data: _Data, num_clues: int) -> _Data:
    """Return at most so many of the clues, evenly spread."""
    clues, points, ends = data
    kept = np.unique(np.linspace(0, len(clues) - 1, num_clues).astype(int))
    parts = np.split(points, ends[:-1])
    return (
        clues[kept],
        np.concatenate([parts[k] for k in kept]),
        np.diff(ends, prepend=0)[kept].cumsum(),
    )


def _best_cells(data: _Data, middle: np.ndarray, config: TeamFilterConfig) -> list[np.ndarray]:
    """Return the best cells of the grid, apart from each other, shape (NUM_UNKNOWNS,) each."""
    low = middle.min(axis=0) - config.start_margin_m
    high = middle.max(axis=0) + config.start_margin_m
    xs, ys = (np.arange(low[k], high[k] + config.start_step_m, config.start_step_m) for k in (0, 1))
    yaws = np.linspace(-np.pi, np.pi, _NUM_YAWS, endpoint=False)
    costs = cell_costs(xs, ys, yaws, *_thinned(data, _MAX_GRID_CLUES))
    order = np.argsort(costs, axis=None)[: 40 * _NUM_REFINED]
    cells: list[np.ndarray] = []
    taken = np.zeros(costs.shape, dtype=bool)
    for i, j, k in zip(*np.unravel_index(order, costs.shape), strict=True):
        if len(cells) == _NUM_REFINED or not np.isfinite(costs[i, j, k]):
            break
        if not taken[i, j, k]:
            cells.append(np.array([xs[i], ys[j], yaws[k], 0.0, 0.0]))
            near = np.arange(k - 1, k + 2) % _NUM_YAWS
            taken[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2, near] = True
    return cells


def _refined(
    cell: np.ndarray, data: _Data, prior: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Return cost, place and covariance of the least squares' answer; None where it has none."""
    place, information = refined(cell, *data, prior)
    if np.linalg.cond(information[:3, :3]) > 1e10 or not np.all(np.isfinite(place)):
        return None
    cov = np.linalg.inv(information)
    cost = cost_of(place, *data, 0.0, 0.0, np.inf) + float(prior @ place**2)
    return cost, place, 0.5 * (cov + cov.T)


def _is_same(a: np.ndarray, b: np.ndarray) -> bool:
    turn = wrap_angle(float(a[2] - b[2]))
    return bool(np.hypot(a[0] - b[0], a[1] - b[1]) < _SAME_M and abs(turn) < _SAME_RAD)
