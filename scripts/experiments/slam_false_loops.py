"""Wrong loops for `slam`, slipped into a growing graph, as sure of themselves as true ones.

Easy to tell: at 40 % of the drive two places more than 5 m apart are one; at 60 % a place of before
is 1 m beside where it is, as the next of a row of like doors; at 80 % there are two of the first
kind that agree with each other. Hard: half a meter off along the robot's way, where a corridor
shows least; once the first time that the robot comes back to where it was, when a lap of drift is
in the graph and hardly a loop to speak against it, and once at 70 %. The truth serves to make them
wrong, and is not told to the graph.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge
from grid_mapper.loop_closer import LoopCloser

FAR_M, BESIDE_M, ALONG_M = 5.0, 1.0, 0.5
COV = np.diag([0.02, 0.02, 0.004]) ** 2
APART_NODES = 4
"""Between the two that agree with each other."""
BACK_M, BACK_RAD, BACK_NODES = 2.0, 0.5, 60
"""The robot is back where it was so many nodes ago if it is this near, and looks the same way."""


class FalseLoops:
    """Slips wrong loops in, each kind once.

    Attributes:
        num_loops_before: Loops in the graph when the first one came, where the robot was back.
    """

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
        self._due: list[tuple[float, Callable[[LoopCloser], list[Edge]]]] = [
            (0.4, self._far), (0.6, self._beside), (0.7, self._along), (0.8, self._far_pair),
        ]  # fmt: skip
        self._num_nodes = 0
        self.num_loops_before: int | None = None

    @property
    def num(self) -> int:
        """Wrong loops so far."""
        return len(self._made)

    def num_kept(self, closer: LoopCloser) -> int:
        """Return how many of them a graph holds."""
        return sum(self.is_made(edge) for edge in closer.edges)

    def is_made(self, edge: Edge) -> bool:
        """Tell whether an edge is one of them."""
        return any(edge is made for made in self._made)

    def slip_in(self, closer: LoopCloser, share: float) -> None:
        """Add what is due at a share of the drive, and have the graph solved."""
        edges = self._first_closure(closer)
        while self._due and share >= self._due[0][0]:
            edges += self._due.pop(0)[1](closer)
        if not edges:
            return
        self._made += edges
        closer.edges += edges
        closer.solve()

    def _first_closure(self, closer: LoopCloser) -> list[Edge]:
        """Return a wrong loop where the robot is back for the first time, none else."""
        num_nodes, num_before = len(closer.frames), self._num_nodes
        self._num_nodes = num_nodes
        if self.num_loops_before is not None or num_nodes in (num_before, *range(BACK_NODES + 1)):
            return []
        nodes = self._nodes(closer)
        first, off = self._nearest(nodes)
        if off.distance > BACK_M or abs(off.yaw) > BACK_RAD:
            return []
        self.num_loops_before = sum(edge.is_loop for edge in closer.edges)
        return [self._moved(nodes, first, ALONG_M)]

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
        return [self._moved(nodes, first, BESIDE_M)]

    def _along(self, closer: LoopCloser) -> list[Edge]:
        nodes = self._nodes(closer)
        return [self._moved(nodes, self._nearest(nodes)[0], -ALONG_M)]

    def _far_pair(self, closer: LoopCloser) -> list[Edge]:
        nodes = self._nodes(closer)
        (loop,) = self._far(closer)
        before, first = loop.second - APART_NODES, loop.first
        # The second says the same of a node a little before: what the chain has between the two.
        moved = closer.poses[loop.second].between(closer.poses[before])
        assert nodes[first].between(nodes[before]).distance > FAR_M / 2.0
        return [loop, Edge(first, before, loop.T_first_second @ moved, COV, is_loop=True)]

    def _nearest(self, nodes: list[SE2]) -> tuple[int, SE2]:
        """Return the earlier node that the newest is nearest to, and the motion from it."""
        before = range(len(nodes) - BACK_NODES)
        first = min(before, key=lambda k: nodes[k].between(nodes[-1]).distance)
        return first, nodes[first].between(nodes[-1])

    def _moved(self, nodes: list[SE2], first: int, along_m: float) -> Edge:
        """Return a loop to the newest node that is off by so much along the way of the first."""
        last = len(nodes) - 1
        seen = nodes[first].between(nodes[last])
        return Edge(first, last, SE2(seen.x + along_m, seen.y, seen.yaw), COV, is_loop=True)

    def _nodes(self, closer: LoopCloser) -> list[SE2]:
        """Return the true poses of all nodes."""
        return [self._truth[frame.stamp_ns] for frame in closer.frames]
