"""Which key scans are kept: as many as the area seen asks for, not as the time does.

Of scans taken in one cell of the floor looking about the same way the newest stay. A node whose
scan is gone stays in the graph with all its edges; only nothing is compared with it any more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.key_frames import KeyFrame
from grid_mapper.surface_points import SurfacePoints

CELL_M, TURN_RAD = 0.5, 0.8
NO_POINTS = SurfacePoints(np.zeros((0, 2)), np.zeros((0, 3)), np.zeros((0, 2)))
NO_SCAN, NO_INFORMATION = Scan(np.zeros(0), 0.0, 1.0, 0.0, 1.0), np.zeros((3, 3))


def emptied(frame: KeyFrame) -> KeyFrame:
    """Return a key frame without its scan."""
    return replace(frame, points=NO_POINTS, scan=NO_SCAN, information=NO_INFORMATION)


def place_key(pose: SE2) -> tuple[float, float, float]:
    """Return the cell of the floor and the way of looking that a pose is of."""
    return pose.x // CELL_M, pose.y // CELL_M, pose.yaw // TURN_RAD


def thinned_frames(frames: Sequence[KeyFrame], poses: Sequence[SE2], most: int) -> list[KeyFrame]:
    """Return the frames, without the scans of those that have `most` newer ones at their place.

    Args:
        frames: Of all nodes.
        poses: Of all nodes, in the map.
        most: Scans kept of a place.
    """
    kept = list(frames)
    num: Counter[tuple[float, float, float]] = Counter()
    for number in range(len(frames) - 1, -1, -1):
        if not len(frames[number].points):
            continue
        place = place_key(poses[number])
        num[place] += 1
        if num[place] > most:
            kept[number] = emptied(frames[number])
    return kept
