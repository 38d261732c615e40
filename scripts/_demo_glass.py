"""How much of the glass beside a robot's way is in its map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from _demo_report import OCCUPIED
from experiments.glass_truth import distance_to_segments, outlines, pane_lines, samples
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

NEAR_GLASS_M = 1.5
_FOUND_M, _APART_M = 0.10, 0.10
_MOST_LEGS = 2000


def glass_recall(
    grid: OccupancyMap | None, start: SE2, solids: Sequence[Solid], way: np.ndarray
) -> float | None:
    """Return the share of the glass near the way that is occupied in a map; None without any.

    Glass is taken every 5 cm. It counts where the robot's middle came within 1.5 m of it and
    nothing opaque stands within 10 cm; it is found if an occupied cell lies within 10 cm.
    """
    panes = pane_lines([solid for solid in solids if solid.glass is not None])
    points = samples(panes)
    if grid is None or not len(points) or len(way) < 2:
        return None
    opaque = outlines([solid for solid in solids if solid.glass is None])
    thin = way[:: max(1, len(way) // _MOST_LEGS)]
    near = distance_to_segments(points, np.hstack((thin[:-1], thin[1:]))) <= NEAR_GLASS_M
    judged = points[near & (distance_to_segments(points, opaque) > _APART_M)]
    occupied = start @ grid.to_points(np.argwhere(grid.cells >= OCCUPIED))
    if not len(judged):
        return None
    if not len(occupied):
        return 0.0
    gaps = np.array([np.hypot(*(occupied - point).T).min() for point in judged])
    return float((gaps <= _FOUND_M).mean())
