"""Wrong loops for `slam`, slipped into a growing graph, as sure of themselves as true ones.

At 40 % of the drive: two places more than 5 m apart are one. At 60 %: a place of before is 1 m
beside where it is, as the next of a row of like doors. At 80 %: two of the first kind that agree
with each other. The truth serves to make them wrong, and is not told to the graph.
"""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge
from grid_mapper.loop_closer import LoopCloser

SHARES = (0.4, 0.6, 0.8)
FAR_M, BESIDE_M = 5.0, 1.0
COV = np.diag([0.02, 0.02, 0.004]) ** 2
APART_NODES = 4
"""Between the two that agree with each other."""


class FalseLoops:
    """Slips wrong loops in, each kind once."""

    def __init__(self, truth: list[SE2], stamps_ns: np.ndarray, rng: np.random.Generator) -> None:
        """Prepare.

        Args:
            truth: Pose of every scan.
            stamps_ns: Of every scan, shape (N,).
            rng: Draws which places.
        """
        self._truth = dict(zip(stamps_ns.tolist(), truth, strict=True))
        self._rng = rng
        self._made: list[Edge] = []
        self._next = 0

    @property
    def num(self) -> int:
        """Wrong loops so far."""
        return len(self._made)

    def num_kept(self, closer: LoopCloser) -> int:
        """Return how many of them a graph holds."""
        return sum(any(edge is made for edge in closer.edges) for made in self._made)

    def slip_in(self, closer: LoopCloser, share: float) -> None:
        """Add what is due at a share of the drive, and have the graph solved."""
        if self._next == len(SHARES) or share < SHARES[self._next]:
            return
        edges = (self._far, self._beside, self._far_pair)[self._next](closer)
        self._next += 1
        self._made += edges
        closer.edges += edges
        closer.solve()

    def _far(self, closer: LoopCloser) -> list[Edge]:
        nodes = self._nodes(closer)
        last = len(nodes) - 1
        far = [k for k in range(last) if nodes[k].between(nodes[last]).distance > FAR_M]
        first = int(self._rng.choice(far))
        turn = float(self._rng.uniform(-np.pi, np.pi))
        return [Edge(first, last, SE2(0.2, 0.1, turn), COV, is_loop=True)]

    def _beside(self, closer: LoopCloser) -> list[Edge]:
        nodes = self._nodes(closer)
        last = len(nodes) - 1
        first = min(range(last // 2), key=lambda k: nodes[k].between(nodes[last]).distance)
        seen = nodes[first].between(nodes[last])
        return [Edge(first, last, SE2(seen.x + BESIDE_M, seen.y, seen.yaw), COV, is_loop=True)]

    def _far_pair(self, closer: LoopCloser) -> list[Edge]:
        nodes = self._nodes(closer)
        (loop,) = self._far(closer)
        before, first = loop.second - APART_NODES, loop.first
        # The second says the same of a node a little before: what the chain has between the two.
        moved = closer.poses[loop.second].between(closer.poses[before])
        assert nodes[first].between(nodes[before]).distance > FAR_M / 2.0
        return [loop, Edge(first, before, loop.T_first_second @ moved, COV, is_loop=True)]

    def _nodes(self, closer: LoopCloser) -> list[SE2]:
        """Return the true poses of all nodes."""
        return [self._truth[frame.stamp_ns] for frame in closer.frames]
