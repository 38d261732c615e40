"""Glass beside a saved map: its own layer, and a mask that keeps robots off it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from floornav_common.grid import FREE, OCCUPIED, OccupancyMap
from grid_mapper.layers_moment import Layers
from grid_mapper.map_files import map_paths, save_map

GLASS, KEEPOUT = "_glass", "_keepout"
SUFFIXES = ("", GLASS, KEEPOUT)


def save_layers(
    prefix: Path | str,
    layers: Layers,
    mode: str = "trinary",
    keepout_margin: float | None = None,
) -> list[Path]:
    """Write the map, and beside it `PREFIX_glass` and `PREFIX_keepout` where there are sonars.

    Args:
        prefix: Path without ending; its folder must exist.
        layers: All maps.
        mode: What is kept of a cell of the map; see `save_map`.
        keepout_margin: How far the mask reaches round glass, m; None writes no mask.

    Returns:
        Paths of the YAML files, that of the map first.

    Raises:
        ValueError: If the mode is unknown or the map has no cells.
        FileExistsError: If one of the files is there; then none is written.
        OSError: If the files cannot be written.
    """
    parts = {"": (layers.occupancy, mode)}
    if layers.sonar.cells.size and layers.glass.cells.size:
        parts[GLASS] = (layers.glass, "trinary")
        if keepout_margin is not None:
            parts[KEEPOUT] = (keepout_mask(layers.glass, keepout_margin), "trinary")
    taken = [name for suffix in parts for name in map_paths(f"{prefix}{suffix}") if name.exists()]
    if taken:
        raise FileExistsError(f"{taken[0]} exists; choose another name")
    return [save_map(f"{prefix}{suffix}", *part) for suffix, part in parts.items()]


def keepout_mask(glass: OccupancyMap, margin: float) -> OccupancyMap:
    """Return a mask for Nav2's keepout filter: occupied within `margin` (m) of glass, else free."""
    reach = margin / glass.resolution
    side = np.arange(-int(reach), int(reach) + 1)
    disc = (np.hypot(side[:, None], side) <= reach).astype(np.uint8)
    near = cv2.dilate((glass.cells == OCCUPIED).astype(np.uint8), disc)
    cells = np.where(near > 0, OCCUPIED, FREE).astype(np.int8)
    return OccupancyMap(cells, glass.resolution, glass.origin)
