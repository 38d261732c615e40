"""Compiled steps of the fit of border to walls (beyond the floor paper's step 6).

A wall n . p = c of the map, seen from (x, y, yaw), is rho = n . e / (c - n . t) at the bearing that
points along e in the map. Measured less that, divided by the deviation that one pixel of noise
makes, is a residual in pixels, z, positive where the border is nearer than the wall. Its
derivatives by the pose are -rho n / (c - n . t) and -n . e' / (c - n . t), e' = e turned by 90
degrees; the border as a whole being d pixels too near adds d.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.floor_walls import NUM_SEEN, wall_ahead, walls_from

NUM_VALUES = 7
"""Columns of the residuals: z, dz/dx, dz/dy, dz/dyaw, wall, rho of the wall, share."""


@numba.njit(cache=True, error_model="numpy", nogil=True)
def residuals(values, step, pose, walls, out):  # type: ignore[no-untyped-def]
    """Fill in residuals of every `step`th piece of border; return how many there are.

    A piece belongs to the wall that its bearing meets first. The wall is -1 where it meets none,
    as from outside.

    Args:
        values: Of `BorderRays`, (N, 7).
        step: 1 for all.
        pose: x, y, yaw of the camera, (3,).
        walls: Of `walls_of`, (W, 8).
        out: (N // step + 1, 7) at least.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    seen = np.empty((len(walls), NUM_SEEN))
    num_seen = walls_from(walls, pose[0], pose[1], seen)
    num = 0
    for i in range(0, len(values), step):
        ex = c * values[i, 0] - s * values[i, 1]
        ey = s * values[i, 0] + c * values[i, 1]
        k, near = wall_ahead(seen, num_seen, ex, ey)
        out[num, 4], out[num, 5], out[num, 6] = -1.0, near, values[i, 6]
        if k >= 0:
            out[num, 4] = seen[k, 7]
            out[num, 0], out[num, 1], out[num, 2], out[num, 3] = residual(
                values[i], seen[k], near, ex, ey
            )
        num += 1
    return num


@numba.njit(cache=True, error_model="numpy", nogil=True)
def residual(value, wall, near, ex, ey):  # type: ignore[no-untyped-def]
    """Return z, dz/dx, dz/dy, dz/dyaw of a piece of border.

    Args:
        value: Row of `BorderRays.values`.
        wall: Row of `walls_from`.
        near: 1 over the distance of the wall.
        ex: The bearing's unit vector in the map.
        ey: The same.
    """
    slope = (wall[2] * ex - wall[1] * ey) * wall[8]
    variance = value[5] - 2.0 * slope * value[4] + slope * slope * value[3]
    scale = 1.0 / np.sqrt(variance)
    turn = -near * wall[8] * scale
    return (value[2] - near) * scale, turn * wall[1], turn * wall[2], -slope * scale


@numba.njit(cache=True, error_model="numpy", nogil=True)
def normal_equations(rows, moves, weights, sd, offset_sd, wall_sd, coarse_m, num_walls):  # type: ignore[no-untyped-def]
    """Return H and b of x, y, yaw, the border's offset and the calibration's K axes, H d = b.

    Every wall may lie off by an offset and a lean of its own, of deviation `wall_sd` each, which
    are eliminated here: the lean shifts the border by the sine of the angle to the wall's normal.

    Args:
        rows: Of `residuals`, (N, 7).
        moves: Of the residuals by the axes of the calibration, (N, K).
        weights: Of the rows, (N,).
        sd: Deviation of a border pixel.
        offset_sd: Deviation of the offset; 0 holds it at 0.
        wall_sd: 0 for none.
        coarse_m: A wall of whose border a pixel covers more than this may lie off so much more.
        num_walls: Walls there are.
    """
    num = 4 + moves.shape[1]
    both = np.zeros((num, num + 1))  # H with b as its last column
    own, counts = np.zeros((num_walls, 2, num + 1)), np.zeros((num_walls, 4))
    _sum_up(rows, moves, weights, sd, both, own, counts)
    for wall in range(num_walls):
        if wall_sd > 0.0 and counts[wall, 0] > 0.0:
            own_sd = wall_sd * max(1.0, counts[wall, 3] / counts[wall, 0] / coarse_m)
            _eliminate(both, own[wall], counts[wall], 1.0 / (own_sd * own_sd))
    H, b = both[:, :num].copy(), both[:, num].copy()
    for j in range(num):
        H[j, :j] = H[:j, j]
    if offset_sd > 0.0:
        H[3, 3] += 1.0 / (offset_sd * offset_sd)
    else:
        H[3, :], H[:, 3], H[3, 3], b[3] = 0.0, 0.0, 1.0, 0.0
    return H, b


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _sum_up(rows, moves, weights, sd, both, own, counts):  # type: ignore[no-untyped-def]
    """Add up what pieces say of the unknowns (4 + K), and of each wall's offset and lean.

    Args:
        rows: As in `normal_equations`.
        moves: The same.
        weights: The same.
        sd: The same.
        both: H and b, upper half.
        own: Of each wall's two by the unknowns and b, (W, 2, 4 + K + 1).
        counts: Of each wall: sums of weights, by lean, by its square, by meters a pixel, (W, 4).
    """
    num = len(both)
    a = np.empty(num + 1)
    for i in range(len(rows)):
        w = weights[i] / (sd * sd)
        if w <= 0.0:
            continue
        a[0], a[1], a[2], a[3] = rows[i, 1], rows[i, 2], rows[i, 3], -1.0
        for k in range(num - 4):
            a[4 + k] = moves[i, k]
        a[num] = -rows[i, 0]
        wall = int(rows[i, 4])
        meters = 1.0 / np.sqrt(a[0] * a[0] + a[1] * a[1])  # of the floor, by pixel
        lean = -a[2] * meters * rows[i, 5]
        for j in range(num):
            for k in range(j, num + 1):
                both[j, k] += w * a[j] * a[k]
        for j in range(num + 1):
            own[wall, 0, j] += w * a[j]
            own[wall, 1, j] += w * a[j] * lean
        counts[wall, 0] += w
        counts[wall, 1] += w * lean
        counts[wall, 2] += w * lean * lean
        counts[wall, 3] += w * meters


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _eliminate(both, own, counts, prior):  # type: ignore[no-untyped-def]
    """Take a wall's offset and lean out of the upper half of H and out of b."""
    p, q, r = counts[0] + prior, counts[1], counts[2] + prior
    det = p * r - q * q
    for j in range(len(both)):
        first = (r * own[0, j] - q * own[1, j]) / det
        second = (p * own[1, j] - q * own[0, j]) / det
        for k in range(j, len(both) + 1):
            both[j, k] -= first * own[0, k] + second * own[1, k]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def moved_residuals(values, moves, pose, walls, rows, out):  # type: ignore[no-untyped-def]
    """Fill in by how much residuals move with each axis of the calibration, (N, K).

    Args:
        values: Of `BorderRays`, (N, 7).
        moves: The same, of bearings and inverse distances, (N, K, 2).
        pose: x, y, yaw of the camera, (3,).
        walls: As in `residuals`.
        rows: Of `residuals` of all pieces there.
        out: (N, K).
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for i in range(len(values)):
        wall = int(rows[i, 4])
        if wall < 0:
            out[i] = 0.0
            continue
        nx, ny = walls[wall, 4], walls[wall, 5]
        ex = c * values[i, 0] - s * values[i, 1]
        ey = s * values[i, 0] + c * values[i, 1]
        slope = (ny * ex - nx * ey) / (walls[wall, 6] - nx * pose[0] - ny * pose[1])
        variance = values[i, 5] - 2.0 * slope * values[i, 4] + slope * slope * values[i, 3]
        scale = 1.0 / np.sqrt(variance)
        for k in range(moves.shape[1]):
            out[i, k] = (moves[i, k, 1] - slope * moves[i, k, 0]) * scale


@numba.njit(cache=True, error_model="numpy", nogil=True)
def gate_weights(rows, offset, gate, margin, weights):  # type: ignore[no-untyped-def]
    """Fill in weights: the share within a gate, 0 outside and up to `margin` pieces beside it."""
    num = len(rows)
    for i in range(num):
        weights[i] = rows[i, 6] if rows[i, 4] >= 0 and abs(rows[i, 0] - offset) <= gate else 0.0
    last = -1 - margin
    for i in range(num):
        if weights[i] == 0.0:
            last = i
        elif i - last <= margin:
            weights[i] = -1.0
    last = num + margin
    for i in range(num - 1, -1, -1):
        if weights[i] == 0.0:
            last = i
        elif last - i <= margin:
            weights[i] = -1.0
    for i in range(num):
        if weights[i] < 0.0:
            weights[i] = 0.0
