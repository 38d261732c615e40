"""Loads what closes loops before the first scan is timed: kernels, and the solver."""

from __future__ import annotations

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.loop_candidates import Candidate
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.loop_verification import verify


def warm_up_loops() -> None:
    """Close a loop in a square.

    Raises:
        ValueError: The solver is not installed.
    """
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    scan = Scan(ranges, -np.pi, 2.0 * np.pi / 180, 0.1, 10.0)
    config, here = GridMapperConfig(), SE2.identity()
    localizer = LoopClosingLocalizer(config)
    for step in range(2):
        turned = SE2(0.0, 0.0, 0.5 * step)
        localizer.insert_scan(step * 1_000_000_000, scan, here, turned)
    closer = localizer.closer
    for sigma in (0.0, 0.1):
        found = Candidate(len(closer.frames) - 1, 0, sigma, sigma)
        verify(closer.frames, closer.poses, found, config.loop, config.matcher)
    closer.solve()
