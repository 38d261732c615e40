"""How well a place fits what a robot saw on its last meters, compiled.

A clue is an angle: of a known thing seen by the robot, from where it was then, or the direction in
the map in which a located teammate saw the robot. All are brought to one pose, the newest, by the
odometry; its doubt since the clue widens what the clue says.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from multi_localizer.team_filter_kernels import wrapped

NUM_UNKNOWNS = 5
"""x, y, yaw, the angle all bearings are off by, the factor of the odometry's turns less 1."""

WORST = 9.0
"""A clue counts against a place by its squared deviations, and by no more than this."""


@njit(cache=True)
def misfit(
    place: np.ndarray,
    clue: np.ndarray,
    points: np.ndarray,
    first: int,
    last: int,
    extra_m2: float,
    extra_rad2: float,
) -> tuple[float, float]:
    """Return how far a clue is off at a place, rad, and its deviation, rad.

    Args:
        place: The unknowns, shape (NUM_UNKNOWNS,).
        clue: x, y, yaw of the robot then seen from now, angle, variance of it, variance of the
            positions and of the yaw by odometry, 1 if a teammate saw the robot; shape (8,).
        points: Positions of what may have been seen, or of the teammate; shape (P, 2).
        first: First of them that is meant.
        last: One behind the last.
        extra_m2: Variance of the position to add, m^2.
        extra_rad2: Variance of the yaw to add, rad^2.
    """
    c, s = np.cos(place[2]), np.sin(place[2])
    x = place[0] + c * clue[0] - s * clue[1]
    y = place[1] + s * clue[0] + c * clue[1]
    yaw = place[2] + (1.0 + place[4]) * clue[2]
    best, best_square = 4.0, 1.0
    for k in range(first, last):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        if clue[7] > 0.0:
            off = wrapped(clue[3] - np.arctan2(-dy, -dx))
        else:
            off = wrapped(clue[3] - place[3] - np.arctan2(dy, dx) + yaw)
        if abs(off) < abs(best):
            best, best_square = off, dx * dx + dy * dy
    var = clue[4] + (clue[5] + extra_m2) / max(best_square, 0.05)
    if clue[7] == 0.0:
        var += clue[6] + extra_rad2
    return best, np.sqrt(var)


@njit(cache=True)
def cost_of(
    place: np.ndarray,
    clues: np.ndarray,
    points: np.ndarray,
    ends: np.ndarray,
    extra_m2: float,
    extra_rad2: float,
    bound: float,
) -> float:
    """Return the sum of the clues' squared deviations, each at most `WORST`; stops at a bound."""
    total, first = 0.0, 0
    for k in range(clues.shape[0]):
        off, sd = misfit(place, clues[k], points, first, ends[k], extra_m2, extra_rad2)
        total += min((off / sd) ** 2, WORST)
        first = ends[k]
        if total > bound:
            break
    return total


@njit(cache=True)
def cell_costs(
    xs: np.ndarray,
    ys: np.ndarray,
    yaws: np.ndarray,
    clues: np.ndarray,
    points: np.ndarray,
    ends: np.ndarray,
) -> np.ndarray:
    """Return the cost of every cell of a grid of poses, shape (X, Y, YAW); inf where hopeless."""
    costs = np.empty((xs.size, ys.size, yaws.size))
    place = np.zeros(NUM_UNKNOWNS)
    extra_m2 = (xs[1] - xs[0]) ** 2 / 6.0
    extra_rad2 = (yaws[1] - yaws[0]) ** 2 / 12.0
    hopeless = 0.35 * WORST * clues.shape[0]
    for i in range(xs.size):
        for j in range(ys.size):
            for k in range(yaws.size):
                place[0], place[1], place[2] = xs[i], ys[j], yaws[k]
                cost = cost_of(place, clues, points, ends, extra_m2, extra_rad2, hopeless)
                costs[i, j, k] = cost if cost <= hopeless else np.inf
    return costs


@njit(cache=True)
def normal_equations(
    place: np.ndarray,
    clues: np.ndarray,
    points: np.ndarray,
    ends: np.ndarray,
    prior: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return J^T W J and -J^T W r of the robust fit at a place; Jacobian by differences."""
    information = np.diag(prior)
    slope = -prior * place
    row = np.zeros(NUM_UNKNOWNS)
    first = 0
    for k in range(clues.shape[0]):
        off, sd = misfit(place, clues[k], points, first, ends[k], 0.0, 0.0)
        for i in range(NUM_UNKNOWNS):
            moved = place.copy()
            moved[i] += 1e-6
            there, _ = misfit(moved, clues[k], points, first, ends[k], 0.0, 0.0)
            row[i] = wrapped(there - off) / 1e-6
        first = ends[k]
        weight = 1.0 / (sd * sd) / (1.0 + (off / sd) ** 2 / WORST) ** 2  # Geman-McClure
        information += weight * np.outer(row, row)
        slope -= weight * row * off
    return information, slope


@njit(cache=True)
def refined(
    place: np.ndarray,
    clues: np.ndarray,
    points: np.ndarray,
    ends: np.ndarray,
    prior: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the least squares' answer from a first place, and its information matrix.

    Args:
        place: The unknowns, shape (NUM_UNKNOWNS,).
        clues: Shape (C, 8).
        points: Shape (P, 2).
        ends: One behind each clue's last point, shape (C,).
        prior: Information on each unknown being 0, shape (NUM_UNKNOWNS,).
    """
    for _ in range(15):
        information, slope = normal_equations(place, clues, points, ends, prior)
        for k in range(NUM_UNKNOWNS):
            information[k, k] = 1.001 * information[k, k] + 1e-6
        step = np.linalg.solve(information, slope)
        step *= min(1.0, 1.0 / max(np.hypot(step[0], step[1]), 1e-9))
        place = place + step
        if np.abs(step).max() < 1e-4:
            break
    information, _ = normal_equations(place, clues, points, ends, prior)
    return place, information
