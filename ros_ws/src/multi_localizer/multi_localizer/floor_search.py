"""Where on the whole plan a border may fit: tried out, when nothing better is known."""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.floor_kernels import NUM_VALUES, residuals
from multi_localizer.floor_plan import FloorPlan

SPACING_M = 0.25
MAX_PLACES = 400
NUM_YAWS = 48
PIECES = 40
NUM_STARTS = 12
_NEAR_PX = 4.0


def places_of(plan: FloorPlan) -> np.ndarray:
    """Return places spread evenly over a plan, (N, 2), m."""
    low, high = plan.corners.min(axis=0), plan.corners.max(axis=0)
    spacing = max(SPACING_M, float(np.sqrt((high - low).prod() / MAX_PLACES)))
    x, y = (
        np.linspace(a, b, int((b - a) / spacing) + 2)[1:-1] for a, b in zip(low, high, strict=True)
    )
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid[[plan.contains(px, py) for px, py in grid]]


def search(values: np.ndarray, walls: np.ndarray, places: np.ndarray) -> list[np.ndarray]:
    """Return the most likely starts for a fit, (3,) each.

    Args:
        values: Of `BorderRays`, (N, 7).
        walls: As in `floor_kernels.residuals`.
        places: To try, (M, 2), m.
    """
    step = max(1, len(values) // PIECES)
    yaws = -np.pi + 2.0 * np.pi / NUM_YAWS * np.arange(NUM_YAWS)
    costs = _costs(values, step, walls, places, yaws)
    best = np.argsort(costs, axis=None)[:NUM_STARTS]
    rows, columns = np.unravel_index(best, costs.shape)
    return [np.array((*places[k], yaws[j])) for k, j in zip(rows, columns, strict=True)]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _costs(values, step, walls, places, yaws):  # type: ignore[no-untyped-def]
    """Return how badly the border fits at each place and yaw, (M, Y)."""
    costs = np.empty((len(places), len(yaws)))
    rows = np.empty((len(values) // step + 1, NUM_VALUES))
    pose = np.empty(3)
    for k in range(len(places)):
        pose[0], pose[1] = places[k, 0], places[k, 1]
        for j in range(len(yaws)):
            pose[2] = yaws[j]
            num = residuals(values, step, pose, walls, rows)
            cost = 0.0
            for i in range(num):
                ratio = (rows[i, 0] / _NEAR_PX) ** 2 if rows[i, 4] >= 0 else 1e9
                cost += ratio / (1.0 + ratio)
            costs[k, j] = cost / num
    return costs
