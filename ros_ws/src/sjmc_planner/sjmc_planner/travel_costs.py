"""What it costs to drive over each cell of a map: the weights of the wave.

Obstacles are grown by the robot; beyond that a cell costs more the nearer an obstacle is, so that
ways keep to the middle of passages where there is room, and cells that are not known cost more, or
are closed.
"""

from __future__ import annotations

import cv2
import numpy as np

from floornav_common.grid import UNKNOWN, OccupancyMap
from sjmc_planner.wavefront_config import WavefrontConfig


def travel_costs(grid: OccupancyMap, config: WavefrontConfig) -> np.ndarray:
    """Return the cost of each cell per meter, shape (H, W), float32; inf where it must not go.

    Args:
        grid: The map.
        config: Robot and weights.
    """
    is_unknown = grid.cells == UNKNOWN
    is_obstacle = grid.cells >= config.occupied_from
    clearance = _clearance(is_obstacle, grid.resolution)
    must = config.radius_m + config.margin_m
    weights = np.ones(grid.cells.shape, dtype=np.float32)
    if config.near_m > 0.0:
        nearness = np.clip(1.0 - (clearance - must) / config.near_m, 0.0, 1.0)
        weights += config.near_weight * nearness**2
    if config.unknown_weight > 0.0:
        weights[is_unknown] *= config.unknown_weight
    else:
        weights[is_unknown] = np.inf
    weights[clearance < must] = np.inf
    return weights


def _clearance(is_obstacle: np.ndarray, resolution: float) -> np.ndarray:
    """Return how far each cell's middle is from the nearest obstacle's edge, shape (H, W), m."""
    if not is_obstacle.any():
        return np.full(is_obstacle.shape, np.inf, dtype=np.float32)
    free = np.where(is_obstacle, 0, 255).astype(np.uint8)
    cells = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray((cells - 0.5) * np.float32(resolution))
