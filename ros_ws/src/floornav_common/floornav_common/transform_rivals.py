"""Two sources of one transform that contradict each other, seen from the samples alone.

TF messages carry no author, and one honest source may jump: when it closes a loop, or is told where
the robot is. It jumps once and stays there. Of two sources that disagree the samples alternate: in
the order of their stamps the transform goes away and comes back, again and again, also where one of
the two has already fallen silent for the other's sake. The order of arrival says nothing: a relay
may hold samples up, and sources stamp theirs ahead by different times.
"""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np

from floornav_common.se2 import SE2

WINDOW_NS = 2_000_000_000
"""Samples so much older than the newest do not count: two sources at 2 Hz show in it."""
APART = 0.3
"""Samples that differ by more are a jump, m or rad, whatever is more."""
MIN_RETURNS = 2
"""One return may be a single bad estimate."""
_BACK_SHARE = 0.5  # of the jump: what comes back so near to where it was before is a return


class BackAndForth:
    """The samples of one transform over the last seconds; nothing here reads a clock."""

    def __init__(self) -> None:
        self._stamps: list[int] = []
        self._poses: list[SE2] = []

    def clear(self) -> None:
        """Begin anew: time jumped back."""
        self._stamps, self._poses = [], []

    def take(self, stamp_ns: int, T_parent_child: SE2) -> None:
        """Take a sample, in any order of stamps; of equal stamps the last one counts."""
        if self._stamps and stamp_ns < self._stamps[-1] - WINDOW_NS:
            return
        at = bisect_left(self._stamps, stamp_ns)
        if at < len(self._stamps) and self._stamps[at] == stamp_ns:
            self._poses[at] = T_parent_child
            return
        self._stamps.insert(at, stamp_ns)
        self._poses.insert(at, T_parent_child)
        num_old = bisect_left(self._stamps, self._stamps[-1] - WINDOW_NS)
        del self._stamps[:num_old], self._poses[:num_old]

    def width(self, point_child: tuple[float, float] = (0.0, 0.0)) -> float:
        """Return how far the transform jumps to and fro, m or rad; 0 if it does not.

        Args:
            point_child: Where in the child frame distances are measured: where the robot is. A
                small turn of map->odom moves what is far from its origin by much.
        """
        if len(self._poses) < MIN_RETURNS + 2:
            return 0.0
        samples = np.array([_seen_at(pose, point_child) for pose in self._poses])
        jumps = np.flatnonzero(_apart(samples[:-1], samples[1:]) > APART)
        before, after = samples[jumps[:-1]], samples[jumps[1:] + 1]
        wide = _apart(samples[jumps[1:]], after)
        returns = _apart(before, after) < _BACK_SHARE * wide
        return float(wide[returns].max()) if np.count_nonzero(returns) >= MIN_RETURNS else 0.0


def _seen_at(pose: SE2, point: tuple[float, float]) -> tuple[float, float, float]:
    """Return where a pose puts a point, and its yaw."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    x, y = point
    return pose.x + c * x - s * y, pose.y + s * x + c * y, pose.yaw


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return how far samples (N, 3) are apart: the distance (m) or the turn (rad), shape (N,)."""
    off = b - a
    turns = np.abs((off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    return np.maximum(np.hypot(off[:, 0], off[:, 1]), turns)
