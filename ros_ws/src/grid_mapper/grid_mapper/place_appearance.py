"""How a place looks from whichever side: how far off its walls are, by share of the points.

The signature of a scan is the cumulative histogram of its points' distances, which no turn of the
robot changes; that of a place is the mean over the nodes round it. The area between two of them
(Rubner et al. 2000, in one dimension) is by how many meters walls are nearer or farther on average.
It is cheap beside comparing two places point by point, and says before that which may be alike.
"""

from __future__ import annotations

import numpy as np

BIN_M, NUM_BINS = 0.5, 20
"""What is farther than all bins counts as in the last."""


def signature(points: np.ndarray) -> np.ndarray:
    """Return the share of points nearer than the end of each bin, shape (NUM_BINS,).

    Args:
        points: Of a scan in the robot's frame, shape (N, 2), m.
    """
    bins = np.minimum(np.hypot(points[:, 0], points[:, 1]) / BIN_M, NUM_BINS - 1).astype(int)
    counts = np.bincount(bins, minlength=NUM_BINS)
    return np.asarray(np.cumsum(counts) / max(1, len(points)))


class Appearances:
    """Signatures of nodes, and how different the places round them look."""

    def __init__(self, num_round: int) -> None:
        """Begin without nodes.

        Args:
            num_round: Nodes to each side that make up a place.
        """
        self._num_round = num_round
        self._sums = np.zeros((1, NUM_BINS))  # of the first k signatures

    def add(self, points: np.ndarray) -> None:
        """Take the next node's points, in its own frame."""
        self._sums = np.vstack((self._sums, self._sums[-1] + signature(points)))

    def differences(self) -> np.ndarray:
        """Return by how much each node's place looks other than the newest's, shape (N,), m."""
        num = len(self._sums) - 1
        low = np.maximum(np.arange(num) - self._num_round, 0)
        high = np.minimum(np.arange(num) + self._num_round + 1, num)
        places = (self._sums[high] - self._sums[low]) / (high - low)[:, None]
        return np.asarray(BIN_M * np.abs(places - places[-1]).sum(axis=1))
