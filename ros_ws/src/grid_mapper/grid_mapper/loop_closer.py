"""Closes loops: takes key frames one after the other, keeps the graph, says where all nodes are."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.frame_thinning import thinned_frames
from grid_mapper.key_frames import UNKNOWN_COV, Edge, KeyFrame, chain_edge, edge_after_jump
from grid_mapper.loop_candidates import Candidate, loop_candidates, near_pairs
from grid_mapper.loop_verification import agree, are_apart, verify
from grid_mapper.node_merging import MergedNodes, contracted, merges_of, moved_edge
from grid_mapper.place_appearance import Appearances
from grid_mapper.pose_graph import (
    FINAL_TOLERANCE,
    QUICK_TOLERANCE,
    GraphSolver,
    deviations_of,
)

MAX_DEVIATIONS = 5.0
"""A loop that the solved graph is further from is taken out again."""
SOLVED_DEVIATIONS, MAX_UNSOLVED = 1.0, 20
"""Loops that the graph is nearer to than this wait for others, until there are so many."""
MAX_PENDING = 20
THINNED_EVERY = 200
"""Nodes after which older scans of one place are thrown out."""


class LoopCloser:
    """The pose graph and its loops.

    Attributes:
        frames: Of all nodes.
        poses: Of all nodes in the map.
        edges: The graph's.
        refused: Candidates that were no loops, by reason.
    """

    def __init__(self, config: GridMapperConfig) -> None:
        self.config = config
        self.frames: list[KeyFrame] = []
        self.poses: list[SE2] = []
        self.edges: list[Edge] = []
        self.refused: Counter[str] = Counter()
        self._ways: list[float] = []
        self._pending: list[Edge] = []
        self._searched_way = -np.inf
        self._num_unsolved = 0
        self._solver = GraphSolver()
        self._looks = Appearances(config.loop.submap_nodes)
        self._merged = MergedNodes()

    @property
    def num_free(self) -> int:
        """Nodes that the graph is solved for: those not merged into others."""
        return len(self.frames) - len(self._merged)

    @property
    def num_loops(self) -> int:
        """Loops in the graph."""
        return sum(edge.is_loop for edge in self.edges)

    def add(self, frame: KeyFrame, *, follows_jump: bool = False) -> bool:
        """Take the next key frame; tell whether poses of earlier ones have changed.

        Args:
            frame: The frame.
            follows_jump: Whether the robot was found again there, not driven from the last one.
        """
        self._append(frame, follows_jump)
        loop = self.config.loop
        if not self.edges:
            return False
        if self._ways[-1] - self._searched_way < loop.search_distance_m:
            return False
        self._searched_way = self._ways[-1]
        looks, has_scan = self._looks.differences(), self._has_scan()
        ways = np.array(self._ways)
        candidates = loop_candidates(self.poses, self.edges, ways, looks, has_scan, loop)
        found = [edge for candidate in candidates for edge in self._compare(candidate)]
        if not found:
            return False
        self.edges += found
        self._num_unsolved += len(found)
        worst = float(deviations_of(found, self.poses).max())
        if worst < SOLVED_DEVIATIONS and self._num_unsolved < MAX_UNSOLVED:
            return False
        self.solve(QUICK_TOLERANCE)
        return True

    def finish(self) -> None:
        """Compare all near places once more at the poses known now; loops found anew replace."""
        if self.num_loops == 0:
            return
        loop, matcher = self.config.loop, self.config.matcher
        pairs = near_pairs(self.poses, np.array(self._ways), self._has_scan(), loop)
        verdicts = [verify(self.frames, self.poses, pair, loop, matcher) for pair in pairs]
        found = [verdict.edge for verdict in verdicts if verdict.edge is not None]
        renewed = {edge.second for edge in found}
        kept = [e for e in self.edges if not (e.is_loop and e.second in renewed)]
        self.edges = kept + found
        self.solve()

    def solve(self, tolerance: float = FINAL_TOLERANCE) -> None:
        """Solve the graph; take out what does not fit, and solve again."""
        self._num_unsolved = 0
        self._place_nodes(tolerance)
        fits = deviations_of(self.edges, self.poses) < MAX_DEVIATIONS
        kept = [e for e, fit in zip(self.edges, fits, strict=True) if fit or not e.is_loop]
        if len(kept) < len(self.edges):
            self.refused["does not fit the graph"] += len(self.edges) - len(kept)
            self.edges = kept
            self._place_nodes(tolerance)

    def _place_nodes(self, tolerance: float) -> None:
        kernel, is_free = self.config.loop.kernel, self._merged.is_free(len(self.frames))
        found = self._solver.solve(self.poses, self.edges, kernel, tolerance, is_free)
        self.poses = self._merged.placed(found)

    def _append(self, frame: KeyFrame, follows_jump: bool) -> None:
        if not self.frames:
            self.poses.append(frame.T_local_base)
            self._ways.append(0.0)
        else:
            loop = self.config.loop
            drift = loop.drift_m, loop.drift_rad
            number = len(self.frames)
            edge = chain_edge(number, self.frames[-1], frame, self.config.motion, drift)
            pose, way = self.poses[-1] @ edge.T_first_second, edge.T_first_second.distance
            if follows_jump:
                self.edges.append(self._edge_after_jump(frame, pose))
                edge = replace(edge, cov=UNKNOWN_COV)
                way += loop.min_way_m  # loops are looked for with all that was seen before
            self.edges.append(edge)
            self.poses.append(pose)
            self._ways.append(self._ways[-1] + way)
        self.frames.append(frame)
        self._looks.add(frame.points.points)
        if len(self.frames) % THINNED_EVERY == 0:
            self._thin()

    def _edge_after_jump(self, frame: KeyFrame, pose: SE2) -> Edge:
        """Return what ties a frame to the nearest node that has a scan."""
        numbers = np.flatnonzero(self._has_scan()).tolist()
        anchor = min(numbers, key=lambda k: self.poses[k].between(pose).distance)
        T, loop = self.poses[anchor].between(pose), self.config.loop
        sigma = loop.loop_sigma_m, loop.loop_sigma_rad
        return edge_after_jump(anchor, len(self.frames), T, frame, self.config.motion, sigma)

    def _thin(self) -> None:
        """Throw out older scans of one place, and let their nodes become part of others."""
        self.frames = thinned_frames(self.frames, self.poses, self.config.loop.max_scans_a_place)
        is_free = self._merged.is_free(len(self.frames))
        merges = merges_of(self.frames, self.poses, self.edges, is_free)
        by_node = {merge.node: merge for merge in merges}
        self.edges = contracted(self.edges, merges)
        self._pending = [moved_edge(edge, by_node) for edge in self._pending]
        self._merged.add(merges)

    def _has_scan(self) -> np.ndarray:
        """Return which nodes still have their scans, shape (N,)."""
        return np.array([len(frame.points) > 0 for frame in self.frames])

    def _compare(self, candidate: Candidate) -> list[Edge]:
        """Return the loops that this candidate brings: none, itself, or itself and one before."""
        loop = self.config.loop
        verdict = verify(self.frames, self.poses, candidate, loop, self.config.matcher)
        edge = verdict.edge
        if edge is None:
            self.refused[verdict.reason] += 1
            return []
        if candidate.sigma_m <= loop.sure_sigma_m:
            return [edge]
        confirmed = [
            other
            for other in self._pending
            if are_apart(other, edge, loop.submap_nodes) and agree(other, edge, self.poses, loop)
        ]
        if not confirmed:
            self._pending = [*self._pending, edge][-MAX_PENDING:]
            return []
        self._pending = [other for other in self._pending if other not in confirmed]
        return [*confirmed, edge]
