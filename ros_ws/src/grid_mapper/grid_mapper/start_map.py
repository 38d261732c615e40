"""A map that was made before, to begin with: read from its files, and put into grids."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from grid_mapper.glass_files import GLASS
from grid_mapper.map_files import load_map
from grid_mapper.map_surfaces import is_free, is_occupied

IMAGE_ENDINGS = (".pgm", ".png", ".bmp", ".jpg", ".jpeg", ".ppm")


@dataclass(frozen=True)
class StartMap:
    """A map to begin with.

    Attributes:
        occupancy: The map to drive by.
        laser: What of it a laser sees: without its glass.
    """

    occupancy: OccupancyMap
    laser: OccupancyMap


def load_start_map(path: Path | str) -> StartMap:
    """Read a map_server YAML file, and the glass layer beside it if there is one.

    Raises:
        ValueError: If a file cannot be read, or nothing in the map is occupied.
        OSError: If a file is not there.
    """
    path = Path(path)
    _require_map_file(path)
    grid = load_map(path)
    if not is_occupied(grid).any():
        raise ValueError(f"{path} holds no obstacle: nothing in it can be found again")
    glass_path = path.with_name(f"{path.stem}{GLASS}{path.suffix}")
    if not glass_path.exists():
        return StartMap(grid, grid)
    rows, cols = np.nonzero(is_occupied(load_map(glass_path)))
    glass = load_map(glass_path)
    points = glass.origin @ ((np.column_stack((cols, rows)) + 0.5) * glass.resolution)
    cells = grid.cells.copy()
    row, col, inside = _cells_at(grid, points)
    cells[row[inside], col[inside]] = FREE
    return StartMap(grid, OccupancyMap(cells, grid.resolution, grid.origin))


def _require_map_file(path: Path) -> None:
    """Refuse what is beside a map's file, and say what to give instead."""
    if path.is_dir():
        inside = path / "map.yaml"
        example = f"{inside}" if inside.exists() else "a .yaml file of map_bag or save_map"
        raise ValueError(f"{path} is a folder: give the map in it, {example}")
    if path.suffix.lower() in IMAGE_ENDINGS:
        raise ValueError(f"{path} is an image: give the map's file, {path.with_suffix('.yaml')}")


def known_cells(grid: OccupancyMap, resolution: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the known cells of a map on the lattice of grids of ours.

    Args:
        grid: Of any resolution and turn.
        resolution: Of the lattice, whose cell (0, 0) begins at the map frame's origin, m.

    Returns:
        (row, col), shape (N, 2), int64, and for each `OCCUPIED` or `FREE`, shape (N,).
    """
    height, width = grid.cells.shape
    corners = np.array([(0, 0), (width, 0), (0, height), (width, height)]) * grid.resolution
    corners = grid.origin @ corners
    low = np.floor(corners.min(axis=0) / resolution).astype(np.int64)
    high = np.ceil(corners.max(axis=0) / resolution).astype(np.int64)
    cols, rows = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    cells = np.column_stack((rows.ravel(), cols.ravel()))
    row, col, inside = _cells_at(grid, (cells[:, ::-1] + 0.5) * resolution)
    values = np.full(len(cells), UNKNOWN, np.int8)
    labels = np.where(is_occupied(grid), OCCUPIED, np.where(is_free(grid), FREE, UNKNOWN))
    values[inside] = labels[row[inside], col[inside]]
    is_known = values != UNKNOWN
    return cells[is_known], values[is_known]


def _cells_at(grid: OccupancyMap, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return row and column of points (N, 2) in the map frame, and which are inside."""
    local = (grid.origin.inverse() @ points) / grid.resolution
    cols, rows = np.floor(local + 1e-6).astype(np.int64).T
    inside = (rows >= 0) & (rows < grid.cells.shape[0]) & (cols >= 0) & (cols < grid.cells.shape[1])
    return rows, cols, inside
