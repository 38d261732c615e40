"""Figures of a map of a world with glass: how much glass is in it, and what is wrong in it.

Pure functions of cells on one lattice. `cells` are as in OccupancyGrid: -1 unknown, 0 free, 100
occupied; 50 and more count as occupied. Lengths of glass are counted in samples every 5 cm.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from experiments.glass_truth import BEHIND_FROM_M, Truth
from floornav_common.grid import OccupancyMap
from grid_mapper.overlay import EVEN, on_cells_of

METRICS = (
    "glass_recall", "glass_precision", "glass_seen_share", "false_occupied", "wall_error_m",
    "phantom_share",
)  # fmt: skip
WITHIN_M = 0.10
WALL_WITHIN_M = 0.25
SLACK_M = 1e-6


def judge(occupancy: OccupancyMap, glass: OccupancyMap | None, truth: Truth) -> dict[str, float]:
    """Return all figures of one map.

    Args:
        occupancy: The map to drive by.
        glass: What it says is glass; None for a map that says nothing of glass.
        truth: Of the world.
    """
    cells = on_cells_of(occupancy, truth.lattice)
    occupied = truth.lattice.to_points(np.argwhere(cells >= EVEN))
    # Beside something opaque, that would count as glass found.
    judged = truth.glass[truth.is_faced & truth.is_apart]
    claimed = None if glass is None else on_cells_of(glass, truth.lattice) >= EVEN
    return {
        "glass_recall": share_found(judged, occupied),
        "glass_precision": np.nan if claimed is None else precision(claimed, truth.to_glass),
        "false_occupied": false_occupied(cells, truth.to_real),
        "wall_error_m": wall_error(cells, truth.to_opaque, truth.to_glass),
        "phantom_share": phantom_share(cells, truth.to_real, truth.to_glass, truth.is_behind),
        "glass_seen_share": share(truth.is_faced),
        "free_known_m2": float((cells[truth.to_real > WITHIN_M] >= 0).sum())
        * truth.lattice.resolution**2,
    }


def share(mask: np.ndarray) -> float:
    """Return the share that is True; NaN of nothing."""
    return float(mask.mean()) if mask.size else np.nan


def share_found(points: np.ndarray, occupied: np.ndarray) -> float:
    """Return the share of points (N, 2) with an occupied center (M, 2) within 10 cm; NaN if none.

    The share of a length, where the points are evenly spaced along it.
    """
    if not len(points):
        return np.nan
    if not len(occupied):
        return 0.0
    distances, _ = cKDTree(occupied).query(points)
    return share(distances <= WITHIN_M + SLACK_M)


def precision(claimed: np.ndarray, to_glass: np.ndarray) -> float:
    """Return the share, by length, of claimed glass that lies within 10 cm of a pane; NaN if none.

    Claims are thinned to lines first, so that a thick one counts no more than a thin one.

    Args:
        claimed: Cells said to be glass, shape (H, W), bool.
        to_glass: Distance to the nearest pane, shape (H, W), m.
    """
    return share(to_glass[thin(claimed)] <= WITHIN_M + SLACK_M)


def false_occupied(cells: np.ndarray, to_real: np.ndarray) -> float:
    """Return the occupied share of cells that the map knows and that are truly free.

    Free means farther than 10 cm from everything.
    """
    is_free = (to_real > WITHIN_M) & (cells >= 0)
    return share(cells[is_free] >= EVEN)


def wall_error(cells: np.ndarray, to_opaque: np.ndarray, to_glass: np.ndarray) -> float:
    """Return the mean distance of walls' occupied cells to the true surface, m; NaN if none.

    A wall's are those within 0.25 m of an opaque surface and nearer to that than to glass.
    """
    is_wall = (cells >= EVEN) & (to_opaque <= WALL_WITHIN_M) & (to_opaque < to_glass)
    return float(to_opaque[is_wall].mean()) if is_wall.any() else np.nan


def phantom_share(
    cells: np.ndarray, to_real: np.ndarray, to_glass: np.ndarray, is_behind: np.ndarray
) -> float:
    """Return the occupied share of truly free cells more than 15 cm behind panes; NaN if none."""
    there = is_behind & (to_real > WITHIN_M) & (to_glass > BEHIND_FROM_M)
    return share(cells[there] >= EVEN)


def thin(mask: np.ndarray) -> np.ndarray:
    """Return a mask thinned to lines one cell wide (Zhang and Suen 1984)."""
    lines = np.pad(mask.astype(bool), 1)
    while True:
        before = int(lines.sum())
        for turn in (0, 1):
            lines &= ~_removable(lines, turn)
        if int(lines.sum()) == before:
            return lines[1:-1, 1:-1]


def _removable(lines: np.ndarray, turn: int) -> np.ndarray:
    """Return the border cells that one of the two turns of a pass takes away."""
    # P2 ... P9 of the paper: clockwise from the cell above.
    around = [(-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1)]
    p = [np.roll(lines, (-dr, -dc), axis=(0, 1)) for dr, dc in around]
    num = np.sum(p, axis=0)
    steps = np.sum([~a & b for a, b in zip(p, [*p[1:], p[0]], strict=True)], axis=0)
    north, east, south, west = p[0], p[2], p[4], p[6]
    if turn == 0:
        is_open = ~(north & east & south) & ~(east & south & west)
    else:
        is_open = ~(north & east & west) & ~(north & south & west)
    return np.asarray(lines & (num >= 2) & (num <= 6) & (steps == 1) & is_open)
