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

NUM_VALUES = 7
"""Columns of the residuals: z, dz/dx, dz/dy, dz/dyaw, wall, rho of the wall, share."""
BEHIND = 5.0  # how much farther off a piece behind its wall still counts
BEHIND_COST = 3.0  # of a piece behind its wall, 1 for one that is hidden
FALL = 0.6  # of the residual that halves a weight, with every step


@numba.njit(cache=True, error_model="numpy", nogil=True)
def residuals(values, step, pose, walls, out):  # type: ignore[no-untyped-def]
    """Fill in residuals of every `step`th piece of border; return how many there are.

    A piece belongs to the wall that its bearing meets first. The wall is -1 where it meets none,
    as from outside.

    Args:
        values: Of `BorderRays`, (N, 7).
        step: 1 for all.
        pose: x, y, yaw of the camera, (3,).
        walls: Corner, tangent, outward normal, c and length of each edge, (W, 8).
        out: (N // step + 1, 7) at least.
    """
    c, s = np.cos(pose[2]), np.sin(pose[2])
    num, num_walls = 0, len(walls)
    gap = np.empty(num_walls)
    for w in range(num_walls):
        gap[w] = walls[w, 6] - walls[w, 4] * pose[0] - walls[w, 5] * pose[1]
    for i in range(0, len(values), step):
        ex = c * values[i, 0] - s * values[i, 1]
        ey = s * values[i, 0] + c * values[i, 1]
        best, wall = 0.0, -1
        for w in range(num_walls):
            facing = walls[w, 4] * ex + walls[w, 5] * ey
            if facing <= 0.0 or gap[w] <= 0.0 or facing <= best * gap[w]:
                continue
            r = gap[w] / facing
            along = (pose[0] + r * ex - walls[w, 0]) * walls[w, 2]
            along += (pose[1] + r * ey - walls[w, 1]) * walls[w, 3]
            if -1e-9 <= along <= walls[w, 7] + 1e-9:
                best, wall = facing / gap[w], w
        out[num, 4] = wall
        out[num, 5] = best
        out[num, 6] = values[i, 6]
        if wall >= 0:
            nx, ny = walls[wall, 4], walls[wall, 5]
            slope = (ny * ex - nx * ey) / gap[wall]
            variance = values[i, 5] - 2.0 * slope * values[i, 4] + slope * slope * values[i, 3]
            scale = 1.0 / np.sqrt(variance)
            out[num, 0] = (values[i, 2] - best) * scale
            out[num, 1] = -best * nx / gap[wall] * scale
            out[num, 2] = -best * ny / gap[wall] * scale
            out[num, 3] = -slope * scale
        num += 1
    return num


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
    H, b = np.zeros((num, num)), np.zeros(num)
    own, sums = np.zeros((num_walls, 2, num)), np.zeros((num_walls, 2))
    counts, covered = np.zeros((num_walls, 3)), np.zeros(num_walls)
    a = np.empty(num)
    for i in range(len(rows)):
        w = weights[i] / (sd * sd)
        if w <= 0.0:
            continue
        a[0], a[1], a[2], a[3] = rows[i, 1], rows[i, 2], rows[i, 3], -1.0
        a[4:] = moves[i]
        wall = int(rows[i, 4])
        meters = 1.0 / np.sqrt(a[0] * a[0] + a[1] * a[1])  # of the floor, by pixel
        lean = -a[2] * meters * rows[i, 5]
        for j in range(num):
            for k in range(j, num):
                H[j, k] += w * a[j] * a[k]
            b[j] -= w * a[j] * rows[i, 0]
            own[wall, 0, j] += w * a[j]
            own[wall, 1, j] += w * a[j] * lean
        sums[wall, 0] += w * rows[i, 0]
        sums[wall, 1] += w * rows[i, 0] * lean
        counts[wall, 0] += w
        counts[wall, 1] += w * lean
        counts[wall, 2] += w * lean * lean
        covered[wall] += w * meters
    for wall in range(num_walls):
        if wall_sd > 0.0 and counts[wall, 0] > 0.0:
            own_sd = wall_sd * max(1.0, covered[wall] / counts[wall, 0] / coarse_m)
            _eliminate(H, b, own[wall], sums[wall], counts[wall], 1.0 / (own_sd * own_sd))
    for j in range(num):
        for k in range(j):
            H[j, k] = H[k, j]
    if offset_sd > 0.0:
        H[3, 3] += 1.0 / (offset_sd * offset_sd)
    else:
        H[3, :], H[:, 3], H[3, 3], b[3] = 0.0, 0.0, 1.0, 0.0
    return H, b


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _eliminate(H, b, own, sums, counts, prior):  # type: ignore[no-untyped-def]
    """Take a wall's offset and lean out of the upper half of H and out of b."""
    p, q, r = counts[0] + prior, counts[1], counts[2] + prior
    det = p * r - q * q
    for j in range(len(b)):
        first = (r * own[0, j] - q * own[1, j]) / det
        second = (p * own[1, j] - q * own[0, j]) / det
        for k in range(j, len(b)):
            H[j, k] -= first * own[0, k] + second * own[1, k]
        b[j] += first * sums[0] + second * sums[1]


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
    for i in range(len(values)):
        wall = int(rows[i, 4])
        if wall < 0:
            out[i] = 0.0
            continue
        c, s = np.cos(pose[2]), np.sin(pose[2])
        nx, ny = walls[wall, 4], walls[wall, 5]
        ex = c * values[i, 0] - s * values[i, 1]
        ey = s * values[i, 0] + c * values[i, 1]
        slope = (ny * ex - nx * ey) / (walls[wall, 6] - nx * pose[0] - ny * pose[1])
        variance = values[i, 5] - 2.0 * slope * values[i, 4] + slope * slope * values[i, 3]
        for k in range(moves.shape[1]):
            out[i, k] = (moves[i, k, 1] - slope * moves[i, k, 0]) / np.sqrt(variance)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def anneal(values, step, start, walls, first, spread, num_iterations):  # type: ignore[no-untyped-def]
    """Find a pose near another one by weights that fall with the residual, less and less gently.

    Args:
        values: Of `BorderRays`.
        step: Every so many pieces count.
        start: Pose to begin with, (3,).
        walls: As in `residuals`.
        first: Residual that halves a weight in the beginning, pixels.
        spread: The same in the end.
        num_iterations: Steps at most.

    Returns:
        The pose (3,), the border's offset, and the cost: 0 all border fits, 1 all is hidden; floor
        behind walls costs more.
    """
    pose, offset, cost = start.copy(), 0.0, 1.0
    rows = np.empty((len(values) // step + 1, NUM_VALUES))
    weights, no_moves = np.empty(len(rows)), np.empty((len(rows), 0))
    scale = first / FALL
    for _ in range(num_iterations):
        num = residuals(values, step, pose, walls, rows)
        off = np.abs(rows[:num, 0] - offset)
        off[rows[:num, 4] < 0] = np.inf
        scale = max(spread, FALL * scale)
        cost, total = 0.0, 0.0
        for i in range(num):
            # Little shows floor behind a wall, but much hides a wall.
            is_behind = rows[i, 0] < offset and scale > spread
            ratio = off[i] / (BEHIND * scale if is_behind else scale)
            ratio *= ratio
            weights[i] = rows[i, 6] / (1.0 + ratio) ** 2 if ratio < 25.0 else 0.0
            ratio = (off[i] / spread) ** 2
            part = ratio / (1.0 + ratio) if ratio < 1e9 else 1.0
            cost += rows[i, 6] * (part * BEHIND_COST if rows[i, 0] < offset - spread else part)
            total += rows[i, 6]
        cost /= total
        H, b = normal_equations(
            rows[:num], no_moves[:num], weights[:num], 1.0, 1.0, 0.0, 1.0, len(walls)
        )
        for j in range(3):
            H[j, j] += 1e-9 + 1e-6 * H[j, j]
        d = np.linalg.solve(H, b)
        pose[0] += d[0]
        pose[1] += d[1]
        pose[2] += d[2]
        offset = d[3]
        if scale == spread and abs(d[0]) + abs(d[1]) + abs(d[2]) < 1e-4:
            break
    return pose, offset, cost


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
