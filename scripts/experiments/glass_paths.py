"""Plain A* with inflation on a map, and whether its paths lead through glass.

Free cells at least 0.3 m (centers) from occupied ones can be driven; unknown ones cannot. Steps go
to 8 neighbors; a start or goal that cannot be driven is moved to the nearest cell that can, up to
0.5 m. Starts lie on the way that the robot drove, goals anywhere that it could truly reach; a
second set has goals on free floor that was seen through glass, be there a way to it or not.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numba
import numpy as np
from scipy import ndimage

from experiments.glass_truth import Truth
from floornav_common.grid import OccupancyMap
from grid_mapper.overlay import EVEN

INFLATION_M = 0.30
SNAP_M = 0.50
_STEPS = np.array([(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)])


@dataclass
class Crossed:
    """What became of start-goal pairs.

    Attributes:
        pairs: Asked for.
        paths: Found.
        crossing: Of these, leading through a pane.
        crossing_faced: Of these, where a sonar had faced the pane often enough.
    """

    pairs: int = 0
    paths: int = 0
    crossing: int = 0
    crossing_faced: int = 0

    def add(self, other: Crossed) -> None:
        """Add the counts of another world."""
        for name in vars(self):
            setattr(self, name, getattr(self, name) + getattr(other, name))


def pairs_of(truth: Truth, num: int, rng: np.random.Generator) -> np.ndarray:
    """Return starts on the driven way and goals truly reachable from it, rows (x1, y1, x2, y2)."""
    is_free = _is_free(truth)
    regions, _ = ndimage.label(is_free, np.ones((3, 3)))
    on_way = truth.lattice.to_cells(truth.path)
    on_way = on_way[is_free[tuple(on_way.T)]]
    region = np.bincount(regions[tuple(on_way.T)]).argmax()
    on_way = on_way[regions[tuple(on_way.T)] == region]
    goals = np.argwhere(regions == region)
    starts = truth.lattice.to_points(on_way[rng.integers(len(on_way), size=num)])
    return np.hstack((starts, truth.lattice.to_points(goals[rng.integers(len(goals), size=num)])))


def pairs_behind_glass(truth: Truth, num: int, rng: np.random.Generator) -> np.ndarray:
    """Return starts on the driven way and goals seen through glass, rows (x1, y1, x2, y2).

    There are none where nothing free was seen through glass.
    """
    is_free = _is_free(truth)
    on_way = truth.lattice.to_cells(truth.path)
    on_way = on_way[is_free[tuple(on_way.T)]]
    goals = np.argwhere(is_free & truth.is_behind)
    if not len(goals):
        return np.zeros((0, 4))
    starts = truth.lattice.to_points(on_way[rng.integers(len(on_way), size=num)])
    return np.hstack((starts, truth.lattice.to_points(goals[rng.integers(len(goals), size=num)])))


def count_crossings(occupancy: OccupancyMap, truth: Truth, pairs: np.ndarray) -> Crossed:
    """Plan for every pair on a map and count the paths that lead through panes."""
    can_drive = drivable(occupancy)
    counts = Crossed(pairs=len(pairs))
    for pair in pairs:
        path = plan(occupancy, can_drive, pair[:2], pair[2:])
        if path is None:
            continue
        counts.paths += 1
        places = crossings(path, truth.panes)
        counts.crossing += len(places) > 0
        if len(places):
            off = np.hypot(*(places[:, None] - truth.glass[None]).transpose(2, 0, 1))
            counts.crossing_faced += bool(truth.is_faced[off.argmin(axis=1)].any())
    return counts


def _is_free(truth: Truth) -> np.ndarray:
    return truth.to_real > INFLATION_M


def drivable(occupancy: OccupancyMap) -> np.ndarray:
    """Return which cells are free and far enough from occupied ones, shape (H, W)."""
    is_occupied = occupancy.cells >= EVEN
    is_free = (occupancy.cells >= 0) & ~is_occupied
    if not is_occupied.any():
        return is_free
    distance = ndimage.distance_transform_edt(~is_occupied) * occupancy.resolution
    return np.asarray(is_free & (distance >= INFLATION_M))


def plan(
    occupancy: OccupancyMap, can_drive: np.ndarray, start: np.ndarray, goal: np.ndarray
) -> np.ndarray | None:
    """Return the shortest path between points of the map frame, (N, 2), m; None if there is none.

    Args:
        occupancy: Says where the cells are.
        can_drive: See `drivable`.
        start: (x, y), m.
        goal: (x, y), m.
    """
    ends = [_snapped(cell, can_drive, SNAP_M / occupancy.resolution)
            for cell in occupancy.to_cells(np.array((start, goal)))]  # fmt: skip
    if ends[0] is None or ends[1] is None:
        return None
    cells = search(can_drive, ends[0], ends[1])
    return occupancy.to_points(cells) if len(cells) else None


def crossings(path: np.ndarray, panes: np.ndarray) -> np.ndarray:
    """Return where a path (N, 2) crosses segments (P, 4), shape (K, 2), m."""
    if len(path) < 2 or not len(panes):
        return np.zeros((0, 2))
    a, d = path[:-1, None], np.diff(path, axis=0)[:, None]
    e, off = panes[None, :, 2:] - panes[None, :, :2], panes[None, :, :2] - a
    cross = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (off[..., 0] * e[..., 1] - off[..., 1] * e[..., 0]) / cross
        s = (off[..., 0] * d[..., 1] - off[..., 1] * d[..., 0]) / cross
    step, _ = hit = np.nonzero((t >= 0.0) & (t <= 1.0) & (s >= 0.0) & (s <= 1.0))
    return np.asarray(a[step, 0] + t[hit][:, None] * d[step, 0])


def _snapped(cell: np.ndarray, can_drive: np.ndarray, reach: float) -> np.ndarray | None:
    """Return the nearest cell that can be driven, up to `reach` cells away; None if none."""
    low = np.maximum(cell - math.ceil(reach), 0)
    high = np.maximum(cell + math.ceil(reach) + 1, 0)
    near = np.argwhere(can_drive[low[0] : high[0], low[1] : high[1]]) + low
    if not len(near):
        return None
    distances = np.hypot(*(near - cell).T)
    return np.asarray(near[distances.argmin()]) if distances.min() <= reach else None


@numba.njit(cache=True)
def search(can_drive, start, goal):  # type: ignore[no-untyped-def]
    """Return the cells of a shortest path by A*, shape (N, 2); (0, 2) if there is none.

    Args:
        can_drive: Shape (H, W), bool.
        start: (row, col).
        goal: (row, col).
    """
    rows, cols = can_drive.shape
    cost = np.full((rows, cols), np.inf)
    came = np.full((rows, cols), -1, np.int8)
    cost[start[0], start[1]] = 0.0
    heap = [(0.0, start[0], start[1])]
    while len(heap) > 0:
        estimate, r, c = heapq.heappop(heap)
        if r == goal[0] and c == goal[1]:
            break
        if estimate > cost[r, c] + _octile(r - goal[0], c - goal[1]) + 1e-9:
            continue
        for k in range(8):
            y, x = r + _STEPS[k, 0], c + _STEPS[k, 1]
            if not (0 <= y < rows and 0 <= x < cols and can_drive[y, x]):
                continue
            if not (can_drive[r, x] and can_drive[y, c]):  # cuts no corner
                continue
            new = cost[r, c] + (1.0 if k < 4 else math.sqrt(2.0))
            if new < cost[y, x] - 1e-12:
                cost[y, x], came[y, x] = new, k
                heapq.heappush(heap, (new + _octile(y - goal[0], x - goal[1]), y, x))
    return _way_back(came, cost, start, goal)


@numba.njit(cache=True)
def _way_back(came, cost, start, goal):  # type: ignore[no-untyped-def]
    if not np.isfinite(cost[goal[0], goal[1]]):
        return np.empty((0, 2), np.int64)
    way = [(goal[0], goal[1])]
    while way[-1] != (start[0], start[1]):
        r, c = way[-1]
        k = came[r, c]
        way.append((r - _STEPS[k, 0], c - _STEPS[k, 1]))
    cells = np.empty((len(way), 2), np.int64)
    for i in range(len(way)):
        cells[i, 0], cells[i, 1] = way[len(way) - 1 - i]
    return cells


@numba.njit(cache=True)
def _octile(rows, cols):  # type: ignore[no-untyped-def]
    low, high = min(abs(rows), abs(cols)), max(abs(rows), abs(cols))
    return high + (math.sqrt(2.0) - 1.0) * low
