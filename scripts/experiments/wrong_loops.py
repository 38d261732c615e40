"""Which loops of a graph are wrong, by the true poses of its nodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge

FALSE_M, FALSE_RAD = 0.3, 0.09
"""A loop that is further off than this is wrong."""


def num_wrong(loops: Iterable[Edge], truth: Sequence[SE2]) -> int:
    """Return how many loops are off by more than `FALSE_M` or `FALSE_RAD`.

    Args:
        loops: Edges between nodes.
        truth: True pose of each node.
    """
    off = [e.T_first_second.between(truth[e.first].between(truth[e.second])) for e in loops]
    return sum(o.distance > FALSE_M or abs(o.yaw) > FALSE_RAD for o in off)
