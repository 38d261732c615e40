"""The arithmetic of the team's filter: one joint Gaussian over all robots (EKF), compiled.

Each robot has `SIZE` states: x, y, yaw in the map frame, and what its sensors do wrong: the angle
all bearings are off by, the factor they are stretched by less 1, the same of the way and of the
turns that the odometry tells, the curve it drives when told to go straight (rad/m), and by how much
the factor of the way grows with the rate of turning (s; below zero where robots slow down in
curves and their odometry does not say so).
"""

from __future__ import annotations

import numpy as np
from numba import njit

X, Y, YAW, OFFSET, SCALE, TRAVEL, TURN, CURVE, DRAG = range(9)
SIZE = 9
NOT_A_ROBOT = -1

_TOO_NEAR = 0.01
"""Square of the distance, m^2, at which a bearing says nothing."""


@njit(cache=True)
def wrapped(angle: float) -> float:
    """Return the angle in [-pi, pi)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@njit(cache=True)
def predict_robot(
    mean: np.ndarray,
    cov: np.ndarray,
    robot: int,
    motion: np.ndarray,
    motion_cov: np.ndarray,
    walk: np.ndarray,
    turn_rate: float,
) -> None:
    """Move one robot and what is known of it with regard to the others, in place.

    Args:
        mean: Of all states, shape (N * SIZE,).
        cov: Of all states, shape (N * SIZE, N * SIZE).
        robot: Which one.
        motion: x, y, yaw of its new pose seen from the old one, by its odometry.
        motion_cov: Covariance of that in the axes of the old pose, (3, 3).
        walk: Variance added to each of the robot's states, shape (SIZE,).
        turn_rate: How fast the robot turned, either way, rad/s.
    """
    o = robot * SIZE
    c, s = np.cos(mean[o + YAW]), np.sin(mean[o + YAW])
    tx, ty = c * motion[0] - s * motion[1], s * motion[0] + c * motion[1]
    way = np.hypot(motion[0], motion[1])
    grow = 1.0 + mean[o + TRAVEL] + turn_rate * mean[o + DRAG]
    turn = 1.0 + mean[o + TURN]
    mean[o + X] += grow * tx
    mean[o + Y] += grow * ty
    mean[o + YAW] += turn * motion[2] + mean[o + CURVE] * way
    for other in range(mean.size):
        yaw = cov[o + YAW, other]
        travel = cov[o + TRAVEL, other] + turn_rate * cov[o + DRAG, other]
        cov[o + X, other] += -grow * ty * yaw + tx * travel
        cov[o + Y, other] += grow * tx * yaw + ty * travel
        cov[o + YAW, other] += motion[2] * cov[o + TURN, other] + way * cov[o + CURVE, other]
    for other in range(mean.size):
        yaw = cov[other, o + YAW]
        travel = cov[other, o + TRAVEL] + turn_rate * cov[other, o + DRAG]
        cov[other, o + X] += -grow * ty * yaw + tx * travel
        cov[other, o + Y] += grow * tx * yaw + ty * travel
        cov[other, o + YAW] += motion[2] * cov[other, o + TURN] + way * cov[other, o + CURVE]
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    cov[o : o + 3, o : o + 3] += axes @ motion_cov @ axes.T
    for state in range(SIZE):
        cov[o + state, o + state] += walk[state]


@njit(cache=True)
def look(
    mean: np.ndarray,
    cov: np.ndarray,
    robot: int,
    bearing: float,
    target: int,
    point: np.ndarray,
    gain: np.ndarray,
) -> tuple[float, float]:
    """Compare a bearing with what is expected of it.

    Args:
        mean: Of all states.
        cov: Of all states.
        robot: Who sees.
        bearing: What it measured, rad.
        target: The robot seen, or `NOT_A_ROBOT` for a landmark.
        point: The landmark's position in the map frame, shape (2,).
        gain: Filled with cov @ H^T, shape (N * SIZE,).

    Returns:
        Measured less expected, rad, and the variance of the expected bearing, rad^2; a variance
        below zero if the target is too near.
    """
    o, t = robot * SIZE, target * SIZE
    dx, dy = point[0] - mean[o + X], point[1] - mean[o + Y]
    if target != NOT_A_ROBOT:
        dx, dy = mean[t + X] - mean[o + X], mean[t + Y] - mean[o + Y]
    square = dx * dx + dy * dy
    if square < _TOO_NEAR:
        return 0.0, -1.0
    seen = wrapped(np.arctan2(dy, dx) - mean[o + YAW])
    grow = 1.0 + mean[o + SCALE]
    hx, hy = grow * dy / square, -grow * dx / square
    for k in range(mean.size):
        gain[k] = hx * cov[k, o + X] + hy * cov[k, o + Y] - grow * cov[k, o + YAW]
        gain[k] += cov[k, o + OFFSET] + seen * cov[k, o + SCALE]
        if target != NOT_A_ROBOT:
            gain[k] -= hx * cov[k, t + X] + hy * cov[k, t + Y]
    var = hx * gain[o + X] + hy * gain[o + Y] - grow * gain[o + YAW]
    var += gain[o + OFFSET] + seen * gain[o + SCALE]
    if target != NOT_A_ROBOT:
        var -= hx * gain[t + X] + hy * gain[t + Y]
    return wrapped(bearing - grow * seen - mean[o + OFFSET]), var


@njit(cache=True)
def learn(mean: np.ndarray, cov: np.ndarray, gain: np.ndarray, residual: float, var: float) -> None:
    """Correct all robots by one bearing, in place.

    Args:
        mean: Of all states.
        cov: Of all states.
        gain: cov @ H^T, of `look`.
        residual: Measured less expected, rad.
        var: Variance of the residual, rad^2.
    """
    for i in range(mean.size):
        if gain[i] == 0.0:
            continue
        mean[i] += gain[i] * residual / var
        for j in range(mean.size):
            cov[i, j] -= gain[i] * gain[j] / var
