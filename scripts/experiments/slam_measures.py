"""How well a map of walls and panes lies on what truly stands there.

Cells are on the truth's lattice. Judged are cells that the map made at the true poses knows, one
more to each side. Occupied cells of the map within a cell of a true surface, and surface within a
cell of an occupied one, count as common; the union is what is left of both:

    IoU = I / (M + T - I),   I = (M near T + T near M) / 2.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

from experiments.glass_truth import Truth
from floornav_common.grid import OccupancyMap
from grid_mapper.overlay import EVEN, on_cells_of

ON_SURFACE_M = 0.036
"""A cell this near to a surface holds a part of it: half a diagonal of 5 cm."""
WITHIN_CELLS = 1.0
SLACK = 1e-6


def seen_area(true_map: OccupancyMap, truth: Truth) -> np.ndarray:
    """Return the cells that are judged, shape (H, W)."""
    known = on_cells_of(true_map, truth.lattice) >= 0
    return np.asarray(binary_dilation(known, np.ones((3, 3), bool)))


def map_iou(occupancy: OccupancyMap, truth: Truth, area: np.ndarray) -> float:
    """Return the intersection over union of occupied cells and true surfaces.

    Args:
        occupancy: The map.
        truth: What stands there.
        area: Cells that are judged, shape (H, W).
    """
    mapped = (on_cells_of(occupancy, truth.lattice) >= EVEN) & area
    surface = (np.minimum(truth.to_opaque, truth.to_glass) <= ON_SURFACE_M) & area
    return tolerant_iou(mapped, surface)


def tolerant_iou(a: np.ndarray, b: np.ndarray) -> float:
    """Return the intersection over union of two masks, a cell beside counting as the same."""
    if not a.any() or not b.any():
        return 0.0
    common = 0.5 * (_num_near(a, b) + _num_near(b, a))
    return float(common / (a.sum() + b.sum() - common))


def _num_near(a: np.ndarray, b: np.ndarray) -> int:
    """Return how many cells of a are within a cell of one of b."""
    distance = distance_transform_edt(~b)
    return int((distance[a] <= WITHIN_CELLS + SLACK).sum())
