"""A layer of obstacles on the cells of another map, whatever its origin, turn and resolution."""

from __future__ import annotations

import numpy as np

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap


def obstacles_on(source: OccupancyMap, like: OccupancyMap) -> OccupancyMap:
    """Return the obstacles of `source` on the cells of `like`, unknown elsewhere.

    A cell is an obstacle if its center lies in an obstacle of the source, or an obstacle's center
    in it: so a thin line stays whole on finer cells and does not vanish on coarser ones.

    Args:
        source: The layer; cells of 100 are obstacles.
        like: Gives origin, size and resolution.
    """
    cells = np.full(like.cells.shape, UNKNOWN, np.int8)
    result = OccupancyMap(cells, like.resolution, like.origin)
    occupied = np.argwhere(source.cells == OCCUPIED)
    if not len(occupied) or not cells.size:
        return result
    points = source.to_points(occupied)
    _mark(cells, result.to_cells(points))
    near = _cells_near(result, points, source.resolution)
    there = source.to_cells(result.to_points(near))
    inside = _is_inside(there, source.cells.shape)
    near, there = near[inside], there[inside]
    _mark(cells, near[source.cells[there[:, 0], there[:, 1]] == OCCUPIED])
    return result


def _mark(cells: np.ndarray, indices: np.ndarray) -> None:
    indices = indices[_is_inside(indices, cells.shape)]
    cells[indices[:, 0], indices[:, 1]] = OCCUPIED


def _is_inside(indices: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    inside: np.ndarray = np.all((indices >= 0) & (indices < shape), axis=1)
    return inside


def _cells_near(grid: OccupancyMap, points: np.ndarray, edge: float) -> np.ndarray:
    """Return the cells of `grid` whose centers can lie within `edge` of a point, shape (N, 2)."""
    reach = int(np.ceil(edge / grid.resolution))
    steps = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    near = (grid.to_cells(points)[:, None, :] + offsets).reshape(-1, 2)
    near = near[_is_inside(near, grid.cells.shape)]
    width = grid.cells.shape[1]
    flat = np.unique(near[:, 0] * width + near[:, 1])
    return np.column_stack((flat // width, flat % width))
