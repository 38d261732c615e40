"""A way over a map from here to a goal, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.grid import OccupancyMap
from sjmc_planner.travel_costs import travel_costs
from sjmc_planner.wavefront import cut_corners, line_cost, nearest_open, wave, way_down
from sjmc_planner.wavefront_config import WavefrontConfig

Cell = tuple[int, int]


class NoWayError(Exception):
    """There is no way; the text says why."""


@dataclass(frozen=True)
class Way:
    """A way over a map.

    Attributes:
        points: From where the robot is to the goal, shape (N, 2), m, in the map's frame.
        cost: What it costs, m of free cells.
    """

    points: np.ndarray
    cost: float


class CostMap:
    """A map as the wave needs it.

    Args:
        grid: The map.
        config: Robot, weights, searches.
    """

    def __init__(self, grid: OccupancyMap, config: WavefrontConfig) -> None:
        self._grid, self._config = grid, config
        self.weights = travel_costs(grid, config)

    def plan(self, start: np.ndarray, goal: np.ndarray) -> Way:
        """Return the cheapest way.

        Args:
            start: Where the robot is, shape (2,), m.
            goal: Where it is to go, shape (2,), m.

        Raises:
            NoWayError: If there is none.
        """
        config = self._config
        end = self._open_cell(goal, "the goal", config.goal_search_m)
        begin = self._open_cell(start, "the robot", config.start_search_m)
        cost = wave(self.weights, *end, *begin)
        cells = way_down(cost, self.weights, *begin)
        if not len(cells):
            raise NoWayError("no way: the goal is walled off from the robot")
        corners = self._grid.to_points(cut_corners(cells, self.weights))
        if end == self._cell(goal):
            corners[-1] = goal
        points = np.concatenate((start[None], corners[1:] if len(corners) > 1 else corners))
        return Way(_spaced(points, config.spacing_m), float(cost[begin]) * self._grid.resolution)

    def cost_of(self, points: np.ndarray) -> float:
        """Return what it costs to drive a line of points, m of free cells; inf if one is closed.

        Where the robot stands, up to where it may leave a closed place from, nothing is closed.

        Args:
            points: Shape (N, 2), m.
        """
        cells = self._grid.to_cells(points)
        is_far = np.hypot(*(points - points[0]).T) > self._config.start_search_m
        cells = cells[is_far] if is_far.any() else cells[-1:]
        if not len(cells) or not all(self._is_inside(cell) for cell in cells):
            return float("inf")
        if not self.weights[tuple(cells[-1])] < np.inf:
            return float("inf")
        legs = zip(cells[:-1], cells[1:], strict=True)
        return sum(line_cost(self.weights, a, b) for a, b in legs) * self._grid.resolution

    def _cell(self, point: np.ndarray) -> Cell:
        row, col = self._grid.to_cells(point[None])[0]
        return int(row), int(col)

    def _is_inside(self, cell: Cell) -> bool:
        height, width = self.weights.shape
        return 0 <= cell[0] < height and 0 <= cell[1] < width

    def _open_cell(self, point: np.ndarray, name: str, reach: float) -> Cell:
        """Return the open cell at a point, or the nearest one.

        Raises:
            NoWayError: If there is none near.
        """
        cell = self._cell(point)
        text = f"{name} at ({point[0]:.2f}, {point[1]:.2f}) m"
        if not self._is_inside(cell):
            raise NoWayError(f"{text} is outside of the map")
        row, col = nearest_open(self.weights, *cell, reach / self._grid.resolution)
        if row < 0:
            raise NoWayError(f"{text} is {self._what(cell)}")
        return int(row), int(col)

    def _what(self, cell: Cell) -> str:
        value = int(self._grid.cells[cell])
        if value >= self._config.occupied_from:
            return "inside an obstacle"
        if value < 0 and self._config.unknown_weight == 0.0:
            return "where the map is unknown"
        return "nearer to an obstacle than the robot's size allows"


def _spaced(points: np.ndarray, spacing: float) -> np.ndarray:
    """Return a line with a point every `spacing` at most, its corners kept, shape (N, 2)."""
    found = [points[:1]]
    for a, b in zip(points[:-1], points[1:], strict=True):
        num = max(1, int(np.ceil(np.hypot(*(b - a)) / spacing - 1e-9)))
        found.append(a + (b - a) * (np.arange(1, num + 1) / num)[:, None])
    return np.concatenate(found)
