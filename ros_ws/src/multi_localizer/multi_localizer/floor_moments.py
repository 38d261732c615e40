"""Centroid and principal axis of a polygon: where the iteration starts (floor paper, step 5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Moments:
    """What a closed region's first moments say.

    Attributes:
        area: m^2.
        center: (x_g, y_g), (2,), m.
        axis_rad: psi, the axis about which the second moment is least, in (-pi/2, pi/2].
    """

    area: float
    center: np.ndarray
    axis_rad: float


def polygon_moments(points: np.ndarray) -> Moments:
    """Return the moments of the area inside a polygon.

    Args:
        points: Its corners in order, either way round, (N, 2), m.

    Raises:
        ValueError: It has no area.
    """
    origin = points.mean(axis=0)
    x, y = (points - origin).T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    area = float(cross.sum() / 2.0)
    if not abs(area) > 1e-9:
        raise ValueError(f"the polygon must have an area, got {area}")
    center = np.array(((x + x2) @ cross, (y + y2) @ cross)) / (6.0 * area)
    xx = (x**2 + x * x2 + x2**2) @ cross / (12.0 * area) - center[0] ** 2
    yy = (y**2 + y * y2 + y2**2) @ cross / (12.0 * area) - center[1] ** 2
    xy = (x * y2 + 2.0 * (x * y + x2 * y2) + x2 * y) @ cross / (24.0 * area) - center.prod()
    return Moments(abs(area), center + origin, 0.5 * math.atan2(2.0 * xy, xx - yy))
