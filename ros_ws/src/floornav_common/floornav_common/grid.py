"""An occupancy grid without ROS: what OccupancyGrid and a map file carry, as numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2

UNKNOWN = -1
FREE = 0
OCCUPIED = 100


@dataclass(frozen=True)
class OccupancyMap:
    """A map in the meaning of nav_msgs/OccupancyGrid.

    Attributes:
        cells: Shape (H, W), int8, `cells[row, col]`, row along +y of the map's own axes;
            -1 unknown, 0 free .. 100 occupied.
        resolution: Cell edge, m.
        origin: Pose of the outer corner of cell (0, 0) in the map frame.
    """

    cells: np.ndarray
    resolution: float
    origin: SE2

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or self.cells.dtype != np.int8:
            raise ValueError(
                f"cells must be (H, W) int8, got {self.cells.shape} {self.cells.dtype}"
            )
        if not self.resolution > 0.0:
            raise ValueError(f"resolution must be > 0 m, got {self.resolution}")

    def to_cells(self, points_map: np.ndarray) -> np.ndarray:
        """Return (row, col) of points of the map frame, shape (N, 2), int; may lie outside."""
        local = self.origin.inverse() @ points_map
        return np.floor(local[:, ::-1] / self.resolution).astype(np.int64)

    def to_points(self, cells: np.ndarray) -> np.ndarray:
        """Return the centres of (row, col) cells in the map frame, shape (N, 2), m."""
        return self.origin @ ((cells[:, ::-1] + 0.5) * self.resolution)
