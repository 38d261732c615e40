"""Cost, gradient and Gauss-Newton Hessian of a pose by views rendered to both sides of it."""

from __future__ import annotations

import numba
import numpy as np

STEP = np.array([0.015, 0.015, 0.012])
"""How far to both sides of a pose views are rendered: m, m, rad."""


@numba.njit(cache=True, error_model="numpy", nogil=True)
def normal_equations(  # type: ignore[no-untyped-def]
    start, stop, color, distance, seen_color, seen_inverse, seen_weight, precision, scales, sums
):
    """Add the cost, its gradient and Gauss-Newton Hessian of poses `start` to `stop` to `sums`.

    Args:
        start: First pose.
        stop: Pose after the last one.
        color: Rendered at each pose and to both sides of it, (N, 7, h, w, 3).
        distance: The same, (N, 7, h, w).
        seen_color: Normalized, (h, w, 3).
        seen_inverse: (h, w).
        seen_weight: (h, w).
        precision: Of the inverse distances, (h, w).
        scales: Of `fit_scales`.
        sums: (N, 10): cost, gradient, upper triangle of the Hessian.
    """
    rows, columns = seen_weight.shape
    color_part, distance_part = scales[0] / (rows * columns), scales[1] / (rows * columns)
    jump = 0.05 * scales[4]
    J, Jc, near = np.empty(3), np.empty((3, 3)), np.empty(7)
    for n in range(start, stop):
        for v in range(rows):
            for u in range(columns):
                is_hit = True
                for k in range(7):
                    far = distance[n, k, v, u]
                    is_hit = is_hit and not np.isnan(far)
                    near[k] = 1.0 / max(far, 0.01)
                if not is_hit:
                    sums[n, 0] += color_part + distance_part * seen_weight[v, u]
                    continue
                is_smooth = True
                for a in range(3):
                    more, less = near[1 + 2 * a], near[2 + 2 * a]
                    J[a] = (more - less) / (2.0 * STEP[a])
                    # A wall's inverse distance is linear over the floor: curvature is an edge.
                    is_smooth = is_smooth and abs(more + less - 2.0 * near[0]) < jump * near[0]
                if distance_part > 0.0:
                    r = near[0] - seen_inverse[v, u]
                    sure = precision[v, u] * scales[3]
                    q = 1.0 / (1.0 + r * r * sure)
                    part = distance_part * seen_weight[v, u]
                    sums[n, 0] += part * (1.0 - q)
                    if is_smooth:
                        _add(sums[n], J, r, 2.0 * part * sure * q * q)
                if color_part > 0.0:
                    _add_color(color[n, :, v, u], seen_color[v, u], color_part, scales[2],
                               is_smooth, Jc, sums[n])  # fmt: skip


@numba.njit(cache=True, error_model="numpy", inline="always")
def _add(out, J, r, weight):  # type: ignore[no-untyped-def]
    """Add a residual with its derivative to gradient and Hessian."""
    k = 4
    for a in range(3):
        out[1 + a] += weight * J[a] * r
        for b in range(a, 3):
            out[k] += weight * J[a] * J[b]
            k += 1


@numba.njit(cache=True, error_model="numpy", inline="always")
def _add_color(rgb, seen, part, scale, is_smooth, Jc, out):  # type: ignore[no-untyped-def]
    """Add a pixel's color: rendered at a pose and to both sides of it, (7, 3)."""
    square = 0.0
    light = max(rgb[0, 0] + rgb[0, 1] + rgb[0, 2], 1e-3)
    for c in range(3):
        square += (rgb[0, c] / light - seen[c]) ** 2
    q = 1.0 / (1.0 + square * scale)
    out[0] += part * (1.0 - q)
    if not is_smooth:
        return
    for a in range(3):
        more = max(rgb[1 + 2 * a, 0] + rgb[1 + 2 * a, 1] + rgb[1 + 2 * a, 2], 1e-3)
        less = max(rgb[2 + 2 * a, 0] + rgb[2 + 2 * a, 1] + rgb[2 + 2 * a, 2], 1e-3)
        for c in range(3):
            change = rgb[1 + 2 * a, c] / more - rgb[2 + 2 * a, c] / less
            Jc[c, a] = change / (2.0 * STEP[a])
    weight = 2.0 * part * scale * q * q
    for c in range(3):
        _add(out, Jc[c], rgb[0, c] / light - seen[c], weight)
