"""Compiles every kernel, so that the first scan is no slower than the rest."""

from __future__ import annotations

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.correlative_search import find_peaks
from grid_mapper.layers import LayeredMapper
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.relocation_messages import Look, NewMap


def compile_kernels(fusion: str = "overlay", has_loops: bool = False) -> None:
    """Map two scans and echoes in a square by both grid rules; compiled code is kept on disk.

    Args:
        fusion: Method whose kernels are wanted.
        has_loops: Whether those of closing loops and of finding a lost robot are wanted too.
    """
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    scan = Scan(ranges, -np.pi, 2.0 * np.pi / 180, 0.1, 10.0)
    here = SE2.identity()
    for grid in ("label", "log_odds"):
        mapper = LayeredMapper(GridMapperConfig(grid=grid, fusion=fusion))
        for step in range(2):
            mapper.insert_range(step, RangeReading(1.0, 0.3, 0.1, 4.0), here, "sonar")
            mapper.insert_scan(step, scan, here, SE2(0.5 * step, 0.0, 0.0))
        _hear_a_pane(mapper)
        mapper.layers()
    if has_loops:
        _compare_places(scan, mapper.laser_map())


def _compare_places(scan: Scan, grid: OccupancyMap) -> None:
    """Look for a scan where it was taken, as loops are closed and lost robots are found."""
    here, config = SE2.identity(), GridMapperConfig()
    find_peaks(scan.points(), scan.points(), here, (0.4, 0.2), 1)
    relocalizer = Relocalizer(config)
    relocalizer.take(NewMap(grid))
    relocalizer.take(Look(0, scan, here, here))


def _hear_a_pane(mapper: LayeredMapper) -> None:
    """Pass a pane: lines are fitted only where echoes agree on one."""
    aside = SE2(0.0, 0.0, np.pi / 2.0)
    for step in range(10):
        place = SE2(0.1 * step, 0.0, 0.0)
        mapper.place_range(step, RangeReading(1.0, 0.3, 0.1, 4.0), aside, "sonar", place)
