"""Compiled: the iterations of scan-to-map ICP; formulas and symbols are those of `scan_matcher`."""

from __future__ import annotations

import numba
import numpy as np

from grid_mapper.surface_map import CXX, CXY, CYY, MX, MY, nearest_cell


@numba.njit(cache=True)
def _normal_equations(  # type: ignore[no-untyped-def]
    points, covs, normals, pose, pool, table, corner, cell_m, max_distance, width
):
    H = np.zeros((3, 3))
    b = np.zeros(3)
    num_pairs, weight_sum, error_sum = 0, 0.0, 0.0
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for i in range(len(points)):
        rx = c * points[i, 0] - s * points[i, 1]
        ry = s * points[i, 0] + c * points[i, 1]
        x, y = rx + pose[0], ry + pose[1]
        nx = c * normals[i, 0] - s * normals[i, 1]
        ny = s * normals[i, 0] + c * normals[i, 1]
        slot, row, col, face = nearest_cell(x, y, nx, ny, pool, table, corner, cell_m, max_distance)
        if slot < 0:
            continue
        cell = pool[slot, row, col, face]
        dx, dy = cell[MX] - x, cell[MY] - y
        xx, xy, yy = covs[i, 0], covs[i, 1], covs[i, 2]
        mxx = cell[CXX] + c * c * xx - 2.0 * c * s * xy + s * s * yy
        mxy = cell[CXY] + c * s * (xx - yy) + (c * c - s * s) * xy
        myy = cell[CYY] + s * s * xx + 2.0 * c * s * xy + c * c * yy
        det = mxx * myy - mxy * mxy
        ixx, ixy, iyy = myy / det, -mxy / det, mxx / det
        error = ixx * dx * dx + 2.0 * ixy * dx * dy + iyy * dy * dy
        w = 1.0 / (1.0 + error / width)
        # W = (1 + k) M^-1 - I / long, k = short / long: the eigenvalues of M
        half = 0.5 * (mxx + myy)
        root = np.sqrt(max(half * half - det, 0.0))
        ratio = (half - root) / (half + root)
        floor = 1.0 / (half + root)
        ixx = (1.0 + ratio) * ixx - floor
        ixy = (1.0 + ratio) * ixy
        iyy = (1.0 + ratio) * iyy - floor
        ex, ey = ixx * dx + ixy * dy, ixy * dx + iyy * dy
        num_pairs += 1
        weight_sum += w
        error_sum += w * error
        # J = d(T p)/d(x, y, yaw) = [I | (-ry, rx)]
        jx, jy = ixx * -ry + ixy * rx, ixy * -ry + iyy * rx
        H[0, 0] += w * ixx
        H[0, 1] += w * ixy
        H[1, 1] += w * iyy
        H[0, 2] += w * jx
        H[1, 2] += w * jy
        H[2, 2] += w * (-ry * jx + rx * jy)
        b[0] += w * ex
        b[1] += w * ey
        b[2] += w * (-ry * ex + rx * ey)
    H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
    return H, b, num_pairs, weight_sum, error_sum


@numba.njit(cache=True)
def register(  # type: ignore[no-untyped-def]
    points, covs, normals, start, pred, prior, pool, table, corner,
    cell_m, max_distance, width, max_iterations, stop_step,
):  # fmt: skip
    """Iterate from a start; return pose, information, number of pairs, sums of weight and error."""
    pose = start.copy()
    H = np.zeros((3, 3))
    num_pairs, weight_sum, error_sum = 0, 0.0, 0.0
    for _ in range(max_iterations):
        H, b, num_pairs, weight_sum, error_sum = _normal_equations(
            points, covs, normals, pose, pool, table, corner, cell_m, max_distance, width
        )
        off = pred - pose
        off[2] = np.pi - (np.pi - off[2]) % (2.0 * np.pi)
        step = np.linalg.solve(H + prior, b + prior @ off)
        pose += step
        if np.abs(step).max() < stop_step:
            break
    return pose, H, num_pairs, weight_sum, error_sum
