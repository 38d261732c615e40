"""The last steps of the fit of border to walls: what is border, how well it says where we are."""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.floor_kernels import (
    NUM_VALUES,
    gate_weights,
    moved_residuals,
    normal_equations,
    residuals,
)

MARGIN = 2  # pieces left out on both sides of an obstacle
BLOCK = 8  # pieces, about as far as neighbors err together
MOST_TOGETHER = 8.0
STILL = 0.1  # deviations of the pose: a step below this is the last but one
FLAT = 0.001, 0.001  # m, rad: over steps so short residuals go as their derivatives say
UNSETTLED = 5.0  # the same: if the last step is longer, the fit has found no rest
_TO_SD = 1.4826


@numba.njit(cache=True, error_model="numpy", nogil=True)
def polish(values, moves, start, offset, walls, limits, num_iterations):  # type: ignore[no-untyped-def]
    """Fit all of the border to the walls, obstacles left out.

    What the calibration leaves open is solved for as well, by its covariance: so the pose's
    covariance has it, and the border tells which way the calibration errs where it can.

    Args:
        values: Of `BorderRays`, (N, 7).
        moves: The same, (N, K, 2).
        start: x, y, yaw, (3,).
        offset: Of the border, px.
        walls: Of `walls_of`, (W, 8).
        limits: border_sd, max_sd, gate_sd, offset_sd, wall_sd, coarse_m.
        num_iterations: Steps at most.

    Returns:
        x, y, yaw, offset and the calibration's axes (4 + K,), covariance of the pose (3, 3),
        deviation of a piece of border, whether the fit came to rest, weights (N,), rows (N, 7).
    """
    state, d = np.zeros(4 + moves.shape[1]), np.zeros(4 + moves.shape[1])
    state[:3], state[3] = start, offset
    rows, weights = np.empty((len(values), NUM_VALUES)), np.empty(len(values))
    by_axis = np.empty((len(values), moves.shape[1]))
    sd, cov = limits[1], np.full((3, 3), np.inf)
    is_last, has_settled = False, False
    for step in range(num_iterations):
        is_last = is_last or step == num_iterations - 1
        if step == 0 or not _moved_on(rows, by_axis, d):
            _see(values, moves, state, walls, rows, by_axis)
        sd = deviation(rows, state[3], limits[2] * sd, limits[0], limits[1])
        gate_weights(rows, state[3], limits[2] * sd, MARGIN, weights)
        together = togetherness(rows, weights, len(walls)) if is_last else 1.0
        d, inverse = _solve(rows, by_axis, weights, sd * np.sqrt(together), limits, state, walls)
        if not inverse[0, 0] > 0.0:
            has_settled = False
            break
        state += d
        cov = inverse[:3, :3].copy()
        has_settled = (d[:3] ** 2 < UNSETTLED**2 * np.diag(cov)).all()
        if is_last:
            break
        is_last = (d[:3] ** 2 < STILL**2 * np.diag(cov)).all()
    return state, cov, sd, has_settled, weights, rows


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _see(values, moves, state, walls, rows, by_axis):  # type: ignore[no-untyped-def]
    """Fill in residuals at a state, and how they move with the calibration's axes."""
    residuals(values, 1, state, walls, rows)
    if moves.shape[1] > 0:
        moved_residuals(values, moves, state, walls, rows, by_axis)
        for i in range(len(rows)):
            for k in range(by_axis.shape[1]):
                rows[i, 0] += by_axis[i, k] * state[4 + k]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _moved_on(rows, by_axis, d):  # type: ignore[no-untyped-def]
    """Move residuals on by a step through their derivatives; tell whether it is so short."""
    if np.hypot(d[0], d[1]) > FLAT[0] or abs(d[2]) > FLAT[1]:
        return False
    for i in range(len(rows)):
        rows[i, 0] += rows[i, 1] * d[0] + rows[i, 2] * d[1] + rows[i, 3] * d[2]
        for k in range(by_axis.shape[1]):
            rows[i, 0] += by_axis[i, k] * d[4 + k]
    return True


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _solve(rows, by_axis, weights, sd, limits, state, walls):  # type: ignore[no-untyped-def]
    """Return the step (4 + K,) of the state and the inverse of H; -1 if the border leaves it open.

    The offset's step is from the offset that is; each of the calibration's axes is known to 1.
    """
    H, b = normal_equations(rows, by_axis, weights, sd, limits[3], limits[4], limits[5], len(walls))
    for k in range(4, len(b)):
        H[k, k] += 1.0
        b[k] -= state[k]
    size = np.sqrt(np.diag(H))
    scaled = H / np.outer(size, size)
    if not (size > 0.0).all() or not np.linalg.cond(scaled) < 1e10:
        return np.zeros(len(b)), np.full((len(b), len(b)), -1.0)
    inverse = np.linalg.inv(scaled) / np.outer(size, size)
    d = inverse @ b
    d[3] -= state[3]
    return d, inverse


@numba.njit(cache=True, error_model="numpy", nogil=True)
def summary(rows, weights, offset, gate):  # type: ignore[no-untyped-def]
    """Return how many pieces are walls', their mean square, and the share that lies behind walls.

    Args:
        rows: Of `residuals`, (N, 7).
        weights: Of the rows, (N,).
        offset: Of the border, px.
        gate: How far behind a wall a piece has to lie, px.
    """
    num, total, beyond = 0, 0.0, 0
    for i in range(len(rows)):
        off = rows[i, 0] - offset
        if weights[i] > 0.0:
            num += 1
            total += off * off
        beyond += rows[i, 4] >= 0 and off < -gate
    return num, total / max(num, 1), beyond / max(len(rows), 1)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def deviation(rows, offset, gate, least, most):  # type: ignore[no-untyped-def]
    """Return the deviation of what lies within a gate of the border's offset, in its limits."""
    near = np.empty(len(rows))
    num = 0
    for i in range(len(rows)):
        off = abs(rows[i, 0] - offset)
        if rows[i, 4] >= 0 and off <= gate:
            near[num] = off
            num += 1
    if num == 0:
        return most
    return min(max(_TO_SD * np.median(near[:num]), least), most)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def togetherness(rows, weights, num_walls):  # type: ignore[no-untyped-def]
    """Return by how much means of neighbors vary more than those of independent pieces would."""
    sums, counts = np.zeros(num_walls), np.zeros(num_walls)
    for i in range(len(rows)):
        if weights[i] > 0.0:
            sums[int(rows[i, 4])] += rows[i, 0]
            counts[int(rows[i, 4])] += 1.0
    total, num, of_blocks, blocks = 0.0, 0.0, 0.0, 0.0
    for first in range(0, len(rows) - BLOCK + 1, BLOCK):
        block, inside = 0.0, 0.0
        for i in range(first, first + BLOCK):
            if weights[i] > 0.0:
                wall = int(rows[i, 4])
                off = rows[i, 0] - sums[wall] / counts[wall]
                block += off
                inside += 1.0
                total += off * off
                num += 1.0
        if inside > 0.0:
            of_blocks += block * block / inside
            blocks += 1.0
    if blocks < 4.0 or total <= 0.0:
        return 1.0
    return min(max(of_blocks / blocks / (total / num), 1.0), MOST_TOGETHER)
