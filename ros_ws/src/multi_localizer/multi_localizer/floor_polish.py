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
        walls: As in `residuals`.
        limits: border_sd, max_sd, gate_sd, offset_sd, wall_sd, coarse_m.
        num_iterations: Steps at most.

    Returns:
        The pose (3,), covariance (3, 3), offset, deviation of a piece of border, whether the fit
        came to rest, weights (N,), rows (N, 7).
    """
    border_sd, max_sd, gate_sd, offset_sd, wall_sd, coarse_m = limits
    pose, num_walls = start.copy(), len(walls)
    rows, weights = np.empty((len(values), NUM_VALUES)), np.empty(len(values))
    sd, together = max_sd, 1.0
    cov = np.full((3, 3), np.inf)
    num_axes = moves.shape[1]
    by_axis, axes = np.empty((len(values), num_axes)), np.zeros(num_axes)
    is_last, has_settled = False, False
    for step in range(num_iterations):
        is_last = is_last or step == num_iterations - 1
        residuals(values, 1, pose, walls, rows)
        if num_axes > 0:
            moved_residuals(values, moves, pose, walls, rows, by_axis)
            rows[:, 0] += by_axis @ axes
        sd = deviation(rows, offset, gate_sd * sd, border_sd, max_sd)
        gate_weights(rows, offset, gate_sd * sd, MARGIN, weights)
        if is_last:
            together = togetherness(rows, weights, num_walls)
        H, b = normal_equations(
            rows, by_axis, weights, sd * np.sqrt(together), offset_sd, wall_sd, coarse_m, num_walls
        )
        for k in range(num_axes):  # each axis is known to 1
            H[4 + k, 4 + k] += 1.0
            b[4 + k] -= axes[k]
        size = np.sqrt(np.diag(H))
        scaled = H / np.outer(size, size)
        if not (size > 0.0).all() or not np.linalg.cond(scaled) < 1e10:
            break
        inverse = np.linalg.inv(scaled) / np.outer(size, size)
        d = inverse @ b
        pose += d[:3]
        offset = d[3]
        axes += d[4:]
        cov = inverse[:3, :3].copy()
        has_settled = (d[:3] ** 2 < UNSETTLED**2 * np.diag(cov)).all()
        if is_last:
            break
        is_last = (d[:3] ** 2 < STILL**2 * np.diag(cov)).all()
    return pose, cov, offset, sd, has_settled, weights, rows


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
