"""Scans of drawn scenes: upright round things and straight walls, without noise unless asked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2

Circle = tuple[float, float, float]
Wall = tuple[float, float, float, float]


def drawn_scan(
    circles: Sequence[Circle] = (), walls: Sequence[Wall] = (), T_world_sensor: SE2 | None = None,
    *, num_beams: int = 720, fov: float = 2.0 * np.pi, range_max: float = 8.0,
    noise: float = 0.0, rng: np.random.Generator | None = None,
) -> Scan:  # fmt: skip
    """Return what a laser sees of circles (x, y, radius) and walls (x1, y1, x2, y2)."""
    T = SE2.identity() if T_world_sensor is None else T_world_sensor
    is_full = fov > 2.0 * np.pi - 1e-6
    step = fov / (num_beams if is_full else num_beams - 1)
    angles = -0.5 * fov + step * np.arange(num_beams)
    ux, uy = np.cos(angles + T.yaw), np.sin(angles + T.yaw)
    ranges = np.full(num_beams, np.inf)
    for x, y, radius in circles:
        along = (x - T.x) * ux + (y - T.y) * uy
        off2 = (x - T.x) ** 2 + (y - T.y) ** 2 - along**2
        with np.errstate(invalid="ignore"):
            near = along - np.sqrt(radius**2 - off2)
        ranges = np.fmin(ranges, np.where(near > 0.0, near, np.nan))
    for x1, y1, x2, y2 in walls:
        ex, ey = x2 - x1, y2 - y1
        with np.errstate(divide="ignore", invalid="ignore"):
            det = ux * ey - uy * ex
            r = ((x1 - T.x) * ey - (y1 - T.y) * ex) / det
            share = ((x1 - T.x) * uy - (y1 - T.y) * ux) / det
        ranges = np.fmin(ranges, np.where((r > 0.0) & (share >= 0.0) & (share <= 1.0), r, np.inf))
    if rng is not None:
        ranges = ranges + noise * rng.standard_normal(num_beams)
    ranges = np.where(ranges > range_max, np.inf, ranges)
    return Scan(ranges, -0.5 * fov, step, 0.05, range_max)
