"""Certainty grid around the robot (Borenstein and Koren 1991: histogramic in-motion mapping).

Cells stay fixed to the floor while the robot moves, and the window moves with the robot: a cell
that leaves it is forgotten. A scan that ends in a cell makes it more certain, one that sees past
it makes it less so; certainties go from 0 to 15 as published. What was made for one sonar along
one axis is done for all beams of a scan at once: a cell gains once a scan, and loses only where the
beams beside its middle end behind it.

Cells lie symmetrically about where the window was started, so that a mirrored scene gives mirrored
cells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamEnds, _seen_to

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
MOST_CERTAIN = 15


@dataclass(frozen=True)
class Cells:
    """The occupied cells of a window.

    Attributes:
        points: Their middles in the base frame, shape (M, 2), m.
        certainty: Share of the highest, in (0, 1], shape (M,).
    """

    points: np.ndarray
    certainty: np.ndarray


class CertaintyWindow:
    """The cells around one robot.

    Args:
        radius: How far it reaches, m.
        cell: Edge of a cell, m.
        hit_gain: What a hit adds.
        miss_loss: What seeing past takes away.
    """

    def __init__(self, radius: float, cell: float, hit_gain: int, miss_loss: int) -> None:
        self._radius, self._cell = radius, cell
        self._gain, self._loss = hit_gain, miss_loss
        num = 2 * (math.ceil(radius / cell) + 1) + 1
        self._counts = np.zeros((num, num), dtype=np.int16)
        self._owner = np.zeros((num, num, 2), dtype=np.int64)  # the cell of the floor it is now
        self._scan = np.zeros((num, num), dtype=np.int64)  # the one that hit it last
        self._num_scans = 0
        self._at = (0.0, 0.0, 0.0)  # the robot, from where the window was started

    def update(self, ends: BeamEnds, moved: SE2) -> Cells:
        """Take a scan; return the cells that are occupied now.

        Args:
            ends: What it shows.
            moved: The robot's motion since the last call.
        """
        x, y, yaw = self._at
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = x + (c * moved.x - s * moved.y), y + (s * moved.x + c * moved.y)
        yaw = math.remainder(yaw + moved.yaw, 2.0 * math.pi)
        self._at = (x, y, yaw)
        self._num_scans += 1
        pose = x, y, math.cos(yaw), math.sin(yaw)
        grid = self._counts, self._owner, self._scan, self._cell, self._radius, pose
        _hit(*grid, ends.points, self._num_scans, self._gain)
        beams = ends.ranges, ends.angle_min, ends.angle_increment, ends.pose
        points, counts = _occupied(*grid, *beams, self._num_scans, self._loss)
        return Cells(points, counts / MOST_CERTAIN)


@numba.njit(cache=True, nogil=True)
def _hit(counts, owner, scans, cell, radius, pose, points, scan, gain):  # type: ignore[no-untyped-def]
    num = len(counts)
    x, y, c, s = pose
    for k in range(len(points)):
        px, py = points[k, 0], points[k, 1]
        if px * px + py * py > radius * radius:
            continue
        i = int(np.rint((x + (c * px - s * py)) / cell))
        j = int(np.rint((y + (s * px + c * py)) / cell))
        a, b = i % num, j % num
        if owner[a, b, 0] != i or owner[a, b, 1] != j:
            owner[a, b, 0], owner[a, b, 1] = i, j
            counts[a, b] = 0
            scans[a, b] = 0
        if scans[a, b] != scan:
            scans[a, b] = scan
            counts[a, b] = min(counts[a, b] + gain, MOST_CERTAIN)


@numba.njit(cache=True, nogil=True)
def _occupied(  # type: ignore[no-untyped-def]
    counts, owner, scans, cell, radius, pose, ranges, angle_min, step, sensor, scan, loss
):
    """Take from what was seen past, forget what left the window, return the rest."""
    num = len(counts)
    x, y, c, s = pose
    points, certain = np.empty((num * num, 2)), np.empty(num * num)
    count = 0
    for a in range(num):
        for b in range(num):
            if counts[a, b] == 0:
                continue
            dx, dy = owner[a, b, 0] * cell - x, owner[a, b, 1] * cell - y
            px, py = c * dx + s * dy, c * dy - s * dx
            if px * px + py * py > (radius + cell) ** 2:
                counts[a, b] = 0
                continue
            if scans[a, b] != scan:
                far, r = _seen_to(px, py, ranges, angle_min, step, sensor)
                if far > r + cell:  # never of NaN
                    counts[a, b] = max(counts[a, b] - loss, 0)
            if counts[a, b] > 0:
                points[count, 0], points[count, 1] = px, py
                certain[count] = counts[a, b]
                count += 1
    return points[:count].copy(), certain[:count].copy()
