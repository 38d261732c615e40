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
NEAR_PX = 4.0
SLIDE_M, SLIDE_PIECES, SLIDE_PX, NUM_SLIDES = 0.04, 120, 1.5, 4
MAX_WAYS, SAME_WAY = 4, 0.98


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
    costs = _costs(values, step, walls, places, yaws, 0.0, NEAR_PX)
    best = np.argsort(costs, axis=None)[:NUM_STARTS]
    rows, columns = np.unravel_index(best, costs.shape)
    return [np.array((*places[k], yaws[j])) for k, j in zip(rows, columns, strict=True)]


def slides(
    values: np.ndarray, walls: np.ndarray, pose: np.ndarray, offset: float, reach: float
) -> list[np.ndarray]:
    """Return starts along the walls from a pose: where more of the border fits than beside it.

    With much of the border hidden, two side walls fit all along, and little says how far along.

    Args:
        values: Of `BorderRays`, (N, 7).
        walls: As in `floor_kernels.residuals`.
        pose: That fits some walls, (3,).
        offset: Of the border there, px.
        reach: Of the plan, m.
    """
    step = max(1, len(values) // SLIDE_PIECES)
    along = np.arange(-reach, reach, SLIDE_M)
    starts = []
    for way in _ways(walls):
        places = pose[:2] + along[:, None] * way
        costs = _costs(values, step, walls, places, pose[2:], offset, SLIDE_PX)[:, 0]
        inner = (costs[1:-1] < costs[:-2]) & (costs[1:-1] <= costs[2:])
        (low,) = np.nonzero(inner)
        for k in low[np.argsort(costs[low + 1])][:NUM_SLIDES] + 1:
            starts.append(np.array((*places[k], pose[2])))
    return starts


def _ways(walls: np.ndarray) -> list[np.ndarray]:
    """Return the different directions of walls, (2,) each."""
    ways: list[np.ndarray] = []
    for tangent in walls[np.argsort(-walls[:, 7]), 2:4]:
        if all(abs(tangent @ way) < SAME_WAY for way in ways):
            ways.append(tangent)
    return ways[:MAX_WAYS]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _costs(values, step, walls, places, yaws, offset, near_px):  # type: ignore[no-untyped-def]
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
                ratio = ((rows[i, 0] - offset) / near_px) ** 2 if rows[i, 4] >= 0 else 1e9
                cost += ratio / (1.0 + ratio)
            costs[k, j] = cost / num
    return costs
