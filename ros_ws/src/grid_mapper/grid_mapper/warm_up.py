"""Compiles every kernel, so that the first scan is no slower than the rest."""

from __future__ import annotations

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.mapper import GridMapper


def compile_kernels() -> None:
    """Map two scans of a square by both rules; compiled code is kept on disk."""
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    scan = Scan(ranges, -np.pi, 2.0 * np.pi / 180, 0.1, 10.0)
    for grid in ("label", "log_odds"):
        mapper = GridMapper(GridMapperConfig(grid=grid))
        for step in range(2):
            mapper.insert_scan(step, scan, SE2.identity(), SE2(0.5 * step, 0.0, 0.0))
        mapper.occupancy()
