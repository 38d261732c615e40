"""Where a loop may close: places that the robot may be at again, as far as the graph knows.

How uncertain a node is seen from the newest one is the sum over the surest way between them, loops
included. A turn that is wrong somewhere on the way moves the end by its lever, so for places near
the newest node each edge counts var_xy + var_yaw * (distance of the edge to the newest node)^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from floornav_common.se2 import SE2
from grid_mapper.key_frames import Edge
from grid_mapper.loop_config import LoopConfig

SIGMAS = 3.0


@dataclass(frozen=True)
class Candidate:
    """Two nodes that may be of one place.

    Attributes:
        query: The one that may be where the other is.
        reference: The other.
        sigma_m: Deviation of one's place seen from the other; 0 to take the graph's word.
        sigma_rad: Deviation of its turn.
    """

    query: int
    reference: int
    sigma_m: float
    sigma_rad: float


def loop_candidates(
    poses: Sequence[SE2], edges: Sequence[Edge], ways: np.ndarray, differences: np.ndarray,
    has_scan: np.ndarray, config: LoopConfig,
) -> list[Candidate]:  # fmt: skip
    """Return the places to compare with the newest node, the likeliest first.

    Where the graph is sure of a place, nearness ranks it. Where it is not, looks do too, and what
    looks too different is left out: there each comparison takes longest and holds least often.

    Args:
        poses: Of all nodes, as the graph has them; the newest is the last.
        edges: Of the graph.
        ways: Length driven up to each node, shape (N,), m.
        differences: How different each node's place looks from the newest's, shape (N,), m.
        has_scan: Which nodes still have their scans, shape (N,), bool.
        config: How far to look.
    """
    newest = len(poses) - 1
    points = np.array([(p.x, p.y) for p in poses])
    sigma_m, sigma_rad = _uncertainty(points, edges, newest)
    distance = np.hypot(*(points - points[newest]).T)
    reach = np.minimum(SIGMAS * sigma_m, config.max_search_m) + config.reach_m
    is_sure = sigma_m <= config.sure_sigma_m
    is_near = (distance < reach) & (ways[newest] - ways > config.min_way_m) & has_scan
    is_near &= is_sure | (differences < config.max_difference_m)
    unlikeness = distance + sigma_m + np.where(is_sure, 0.0, differences)
    nearest = _nearest_of_passes(is_near, distance + np.where(is_sure, 0.0, differences))
    nearest.sort(key=lambda k: float(unlikeness[k]))
    return [
        Candidate(newest, k, float(sigma_m[k]), float(sigma_rad[k]))
        for k in nearest[: config.max_candidates]
    ]


def near_pairs(
    poses: Sequence[SE2], ways: np.ndarray, has_scan: np.ndarray, config: LoopConfig
) -> list[Candidate]:
    """Return pairs of nodes that are near each other by the graph, of every node the nearest.

    Args:
        poses: Of all nodes; their word is taken.
        ways: Length driven up to each node, shape (N,), m.
        has_scan: Which nodes still have their scans, shape (N,), bool.
        config: How far is near.
    """
    points = np.array([(p.x, p.y) for p in poses])
    pairs = []
    for query in np.flatnonzero(has_scan).tolist():
        distance = np.hypot(*(points - points[query]).T)
        is_near = (distance < config.reach_m) & (abs(ways - ways[query]) > config.min_way_m)
        is_near &= has_scan
        nearest = _nearest_of_passes(is_near, distance)
        nearest.sort(key=lambda k: float(distance[k]))
        pairs += [Candidate(query, k, 0.0, 0.0) for k in nearest[: config.max_candidates]]
    return pairs


def _nearest_of_passes(is_near: np.ndarray, distance: np.ndarray) -> list[int]:
    """Return of every run of near nodes, one after the other, the nearest."""
    numbers = np.flatnonzero(is_near)
    if not len(numbers):
        return []
    passes = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    return [int(run[np.argmin(distance[run])]) for run in passes]


def _uncertainty(
    points: np.ndarray, edges: Sequence[Edge], newest: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the deviations of every node's place (m) and turn (rad), seen from the newest."""
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    var_xy = np.array([0.5 * (edge.cov[0, 0] + edge.cov[1, 1]) for edge in edges])
    var_yaw = np.array([edge.cov[2, 2] for edge in edges])
    middles = 0.5 * (points[first] + points[second]) - points[newest]
    lever2 = middles[:, 0] ** 2 + middles[:, 1] ** 2
    var_place = _least_sums(first, second, var_xy + var_yaw * lever2, len(points), newest)
    var_turn = _least_sums(first, second, var_yaw, len(points), newest)
    return np.sqrt(var_place), np.sqrt(var_turn)


def variances_from(
    starts: Sequence[int], edges: Sequence[Edge], num: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the variances of every node's place and turn, seen from some, shape (M, N) each.

    Levers are left out: it is for nodes beside each other.
    """
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    var_xy = np.array([0.5 * (edge.cov[0, 0] + edge.cov[1, 1]) for edge in edges])
    var_yaw = np.array([edge.cov[2, 2] for edge in edges])
    return (
        _least_sums(first, second, var_xy, num, starts),
        _least_sums(first, second, var_yaw, num, starts),
    )


def _least_sums(
    first: np.ndarray, second: np.ndarray, weight: np.ndarray, num: int,
    start: int | Sequence[int],
) -> np.ndarray:  # fmt: skip
    order = np.lexsort((weight, second, first))  # of edges between the same nodes the surest
    pairs = first[order] * num + second[order]
    kept = order[np.concatenate(([True], np.diff(pairs) != 0))]
    graph = csr_matrix((weight[kept], (first[kept], second[kept])), shape=(num, num))
    return np.asarray(dijkstra(graph, directed=False, indices=start))
