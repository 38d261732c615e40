"""A drive past a pane that the laser does not see, a sonar to the left, by any method."""

import math

import numpy as np
from worlds import scan_at

from floornav_common.grid import OCCUPIED
from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper

S = 1_000_000_000
LASER, SONAR = SE2(0.1, 0.0, 0.0), SE2(0.0, 0.1, math.pi / 2.0)
FOV = math.radians(20.0)
PANE_Y = 1.0
NUM_STEPS = 34
STEP_M = 0.06  # more than `sonar_key.distance_m`


def blind_to_glass(x: float) -> Scan:
    """Return a scan of a room 3 m deep to the left and right of a way along x; no pane in it."""
    walls = np.array([(-3.0, y, 7.0, y) for y in (-3.0, 3.0)] + [(7, -3, 7, 3), (-3, -3, -3, 3)])
    return scan_at(SE2(x, 0.0, 0.0) @ LASER, walls.astype(float))


def reading(value: float, low: float = 0.1, high: float = 4.0, fov: float = FOV) -> RangeReading:
    return RangeReading(value, fov, low, high)


def drive(values, *, config: GridMapperConfig | None = None, mapper=None, passes: int = 1):
    """Drive 2 m past a place, a sonar to the left; `values(step, x)` are its readings there."""
    mapper = mapper or LayeredMapper(config or GridMapperConfig(fusion="overlay"))
    number = mapper.laser.num_key_scans * 1000
    for _ in range(passes):
        for step in range(NUM_STEPS):
            x, stamp_ns = step * STEP_M, (number + step) * S // 10
            mapper.place_scan(stamp_ns, blind_to_glass(x), LASER, SE2(x, 0.0, 0.0))
            for k, each in enumerate(values(step, x)):
                mapper.place_range(stamp_ns + k, each, SONAR, "left", SE2(x, 0.0, 0.0))
        number += NUM_STEPS
    return mapper


def cell(grid, x, y):
    row, col = grid.to_cells(np.array([[x, y]]))[0]
    return int(grid.cells[row, col])


def pane(mapper, y=PANE_Y):
    """Return how much of the pane, 0.3 to 1.7 m along the way, the map shows as obstacle."""
    grid = mapper.occupancy()
    return np.mean([
        max(cell(grid, x, y + d) for d in (-0.05, 0.0, 0.05)) == OCCUPIED
        for x in np.arange(0.3, 1.7, 0.05)
    ])  # fmt: skip


def true_echo(step, x):
    return [reading(PANE_Y - SONAR.y)]


def num_glass(mapper):
    return int((mapper.glass_map().cells == OCCUPIED).sum())


# Rows of the table: what a reading does to a map without a pane, and to one with a pane.
SILENT = {
    "NaN": reading(math.nan),
    "+inf": reading(math.inf),
    "-inf": reading(-math.inf),
    "== max": reading(4.0),
    "> max": reading(4.5),
    "< min": reading(0.05),
    "0": reading(0.0),
    "fixed distance, +inf": reading(math.inf, 0.9, 0.9),
    "fixed distance, a number": reading(0.9, 0.9, 0.9),
}
