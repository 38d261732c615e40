"""Nodes that become part of others: where the robot drives all day the graph stops growing.

A node whose scan was thrown out (`frame_thinning`) is merged into the nearest one of its place that
has one, if the graph is sure how the two lie to each other: it keeps its pose seen from there, and
its edges go over, moved by that pose and less sure by what the graph did not know of it. Of edges
between the same two nodes then the surest stays. Chosen by their scans and contracted, where
Johannsson et al. (2013, reduced pose graph) make no new nodes at places known: so the newest stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from grid_mapper.frame_thinning import place_key
from grid_mapper.key_frames import Edge, KeyFrame
from grid_mapper.loop_candidates import variances_from
from grid_mapper.motion import rotated

SURE_SIGMA_M, SURE_SIGMA_RAD = 0.1, 0.05
"""What the graph knows of two nodes worse than this is not merged."""


@dataclass(frozen=True)
class Merge:
    """A node that becomes part of another.

    Attributes:
        node: It.
        into: The other.
        T_into_node: Where it is, seen from the other.
        var_m2: Variance of its place.
        var_rad2: Variance of its turn.
    """

    node: int
    into: int
    T_into_node: SE2
    var_m2: float
    var_rad2: float


class MergedNodes:
    """The nodes merged so far."""

    def __init__(self) -> None:
        self._nodes, self._into = np.zeros(0, int), np.zeros(0, int)
        self._seen = np.zeros((0, 3))

    def __len__(self) -> int:
        return len(self._nodes)

    def add(self, merges: Sequence[Merge]) -> None:
        """Take nodes that are merged now; those that were merged into them go along."""
        by_node = {merge.node: merge for merge in merges}
        for row in np.flatnonzero(np.isin(self._into, list(by_node))).tolist():
            merge = by_node[int(self._into[row])]
            self._into[row] = merge.into
            self._seen[row] = (merge.T_into_node @ SE2(*self._seen[row].tolist())).as_array()
        if merges:
            self._nodes = np.append(self._nodes, [merge.node for merge in merges])
            self._into = np.append(self._into, [merge.into for merge in merges])
            self._seen = np.vstack((self._seen, [m.T_into_node.as_array() for m in merges]))

    def is_free(self, num: int) -> np.ndarray:
        """Return which of so many nodes are merged into none, shape (num,), bool."""
        free = np.ones(num, bool)
        free[self._nodes] = False
        return free

    def placed(self, poses: Sequence[SE2]) -> list[SE2]:
        """Return the poses of all nodes, those merged by the nodes that they are part of."""
        placed = list(poses)
        for node, into, seen in zip(
            self._nodes.tolist(), self._into.tolist(), self._seen.tolist(), strict=True
        ):
            placed[node] = poses[into] @ SE2(*seen)
        return placed


def merges_of(
    frames: Sequence[KeyFrame], poses: Sequence[SE2], edges: Sequence[Edge], is_free: np.ndarray
) -> list[Merge]:
    """Return which nodes without a scan can be merged, and into which.

    Args:
        frames: Of all nodes.
        poses: Of all nodes, in the map.
        edges: Of the graph.
        is_free: Which nodes are merged into none, shape (N,), bool.
    """
    here: dict[tuple[float, float, float], list[int]] = {}
    empty = []
    for number in np.flatnonzero(is_free).tolist():
        if len(frames[number].points):
            here.setdefault(place_key(poses[number]), []).append(number)
        else:
            empty.append(number)
    nearest = {}
    for number in empty:
        others = here.get(place_key(poses[number]), [])
        if others:
            nearest[number] = min(others, key=lambda k: poses[k].between(poses[number]).distance)
    return _sure_merges(nearest, poses, edges)


def _sure_merges(
    nearest: dict[int, int], poses: Sequence[SE2], edges: Sequence[Edge]
) -> list[Merge]:
    if not nearest:
        return []
    starts = sorted(set(nearest.values()))
    row = {start: k for k, start in enumerate(starts)}
    var_m2, var_rad2 = variances_from(starts, edges, len(poses))
    merges = []
    for node, into in nearest.items():
        place, turn = float(var_m2[row[into], node]), float(var_rad2[row[into], node])
        if place <= SURE_SIGMA_M**2 and turn <= SURE_SIGMA_RAD**2:
            merges.append(Merge(node, into, poses[into].between(poses[node]), place, turn))
    return merges


def contracted(edges: Sequence[Edge], merges: Sequence[Merge]) -> list[Edge]:
    """Return the edges of a graph after nodes were merged.

    Edges within a node are gone. Where an edge has moved to between two nodes that have another,
    the surest stays, of the chain before a loop: what held together before still does.
    """
    by_node = {merge.node: merge for merge in merges}
    moved = [moved_edge(edge, by_node) for edge in edges]
    changed = {_ends(new) for old, new in zip(edges, moved, strict=True) if new is not old}
    best: dict[tuple[int, int], Edge] = {}
    for edge in moved:
        if _ends(edge) in changed:
            other = best.get(_ends(edge))
            if other is None or _rank(edge) < _rank(other):
                best[_ends(edge)] = edge
    return [
        edge
        for edge in moved
        if edge.first != edge.second and (_ends(edge) not in changed or best[_ends(edge)] is edge)
    ]


def moved_edge(edge: Edge, by_node: dict[int, Merge]) -> Edge:
    """Return an edge between the nodes that its own are part of; the same one if they are free."""
    if edge.first not in by_node and edge.second not in by_node:
        return edge
    first, second, motion, cov = edge.first, edge.second, edge.T_first_second, edge.cov
    if first in by_node:
        merge = by_node[first]
        cov = cov + _spread(merge.var_m2, merge.var_rad2, motion.distance)
        first, motion = merge.into, merge.T_into_node @ motion
    if second in by_node:
        merge = by_node[second]
        back = merge.T_into_node.inverse()
        cov = rotated(cov, -back.yaw) + _spread(merge.var_m2, 0.0, 0.0)
        cov = cov + _spread(0.0, float(edge.cov[2, 2]) + merge.var_rad2, back.distance)
        cov[2, 2] -= float(edge.cov[2, 2])  # its own turn is in it already
        second, motion = merge.into, motion @ back
    return Edge(first, second, motion, cov, edge.is_loop)


def _spread(var_m2: float, var_rad2: float, lever: float) -> np.ndarray:
    """Return the covariance of a pose behind a lever whose foot is uncertain."""
    place = var_m2 + var_rad2 * lever**2
    return np.diag([place, place, var_rad2])


def _ends(edge: Edge) -> tuple[int, int]:
    return min(edge.first, edge.second), max(edge.first, edge.second)


def _rank(edge: Edge) -> tuple[bool, float]:
    return edge.is_loop, float(np.linalg.det(edge.cov))
