"""Where in a whole map a scan fits: all poses in free space are tried, coarse to fine.

Scores are those of `correlative_search`. A block of positions is scored on a field in which every
cell holds the best of the block's positions, so no position in it scores higher; only blocks that
may hold a pose nearly as good as the best are looked at closer (after Olson 2009 and Hess 2016).
"""

from __future__ import annotations

import cv2
import numba
import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.correlative_search import (
    CELL_M,
    Peak,
    is_same_peak,
    refined_peak,
    score_field,
)
from grid_mapper.map_surfaces import is_free, surfaces_of

BLOCK_CELLS = (16, 8, 4)
FIRST_BLOCKS = 200
"""Blocks looked at closer first, to know what the others have to reach."""
MAX_POINTS = 120
MAX_STARTS = 48
MIN_SCORE = 0.35
"""Where less of the scan fits nothing is looked at closer."""
SLACK = 0.9
"""A block counts by so much of the best found so far: rivals are wanted too."""


class GlobalSearch:
    """Holds the score fields of one map."""

    def __init__(self, grid: OccupancyMap) -> None:
        self.surfaces = surfaces_of(grid)
        self._is_empty = not len(self.surfaces)
        self._grid: OccupancyMap | None = grid

    def find(self, query: np.ndarray, share: float, num: int) -> list[Peak]:
        """Return where points fit best, and wherever they fit by `share` of that.

        Args:
            query: Points of a scan in the robot's frame, shape (N, 2), m.
            share: Of the best score, 0..1.
            num: Peaks returned at most.
        """
        if self._is_empty or not len(query):
            return []
        self._prepare()
        query = np.ascontiguousarray(query[:: max(1, -(-len(query) // MAX_POINTS))])
        radius = float(np.quantile(np.hypot(query[:, 0], query[:, 1]), 0.8))
        turn_step = min(BLOCK_CELLS[-1] * CELL_M / max(radius, 1.0), 0.1)
        turns = np.arange(0.0, 2.0 * np.pi, turn_step)
        nodes, scores = self._coarse(query, turns, share)
        peaks: list[Peak] = []
        for start in self._starts(nodes, scores, turns):
            step = BLOCK_CELLS[-1] * CELL_M
            peaks.append(refined_peak(self._field, self._corner, query, start, step, turn_step))
        return _apart(peaks, share, num)

    def _prepare(self) -> None:
        """Make the fields, once they are needed: a robot that is told where it is needs none."""
        if self._grid is None:
            return
        self._field, self._corner = score_field(self.surfaces.points)
        self._fields = [_best_of_blocks(self._field, size) for size in BLOCK_CELLS]
        self._free = [self._free_blocks(self._grid, size) for size in BLOCK_CELLS]
        self._grid = None

    def _coarse(
        self, query: np.ndarray, turns: np.ndarray, share: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return blocks (turn, row, col) of the finest size worth a closer look; their scores."""
        blocks = np.argwhere(self._free[0])
        numbers = np.arange(len(turns))
        nodes = np.column_stack((np.repeat(numbers, len(blocks)), np.tile(blocks, (len(turns), 1))))
        scores = self._score(0, nodes, query, turns)
        for level in range(1, len(BLOCK_CELLS)):
            ratio = BLOCK_CELLS[level - 1] // BLOCK_CELLS[level]
            first = self._children(nodes[np.argsort(-scores)[:FIRST_BLOCKS]], ratio, level)
            best = float(self._score(level, first, query, turns).max(initial=0.0))
            least = max(MIN_SCORE, SLACK * share * best)
            nodes = self._children(nodes[scores >= least], ratio, level)
            scores = self._score(level, nodes, query, turns)
        least = max(MIN_SCORE, SLACK * share * float(scores.max(initial=0.0)))
        return nodes[scores >= least], scores[scores >= least]

    def _score(
        self, level: int, nodes: np.ndarray, query: np.ndarray, turns: np.ndarray
    ) -> np.ndarray:
        size = BLOCK_CELLS[level]
        return _score_blocks(self._fields[level], nodes, size, query / CELL_M, turns) / 255.0

    def _children(self, nodes: np.ndarray, ratio: int, level: int) -> np.ndarray:
        """Return the blocks of the next size in which the robot can be."""
        steps = np.array([(0, r, c) for r in range(ratio) for c in range(ratio)])
        children = (nodes * (1, ratio, ratio))[:, None] + steps
        children = children.reshape(-1, 3)
        free = self._free[level]
        inside = (children[:, 1] < free.shape[0]) & (children[:, 2] < free.shape[1])
        children = children[inside]
        return children[free[children[:, 1], children[:, 2]]]

    def _starts(self, nodes: np.ndarray, scores: np.ndarray, turns: np.ndarray) -> list[SE2]:
        """Return poses to refine from, the best first, none near a better one."""
        size = BLOCK_CELLS[-1]
        starts: list[SE2] = []
        for k in np.argsort(-scores, kind="stable"):
            turn, row, col = nodes[k]
            x, y = self._corner + (np.array([col, row]) + 0.5) * size * CELL_M
            pose = SE2(float(x), float(y), float(turns[turn]))
            if all(not is_same_peak(pose, other) for other in starts):
                starts.append(pose)
                if len(starts) == MAX_STARTS:
                    break
        return starts

    def _free_blocks(self, grid: OccupancyMap, size: int) -> np.ndarray:
        """Return which blocks of the score field have free cells of the map in them."""
        rows, cols = np.nonzero(is_free(grid))
        places = grid.origin @ ((np.column_stack((cols, rows)) + 0.5) * grid.resolution)
        blocks = np.floor((places - self._corner) / (size * CELL_M)).astype(int)
        shape = -(-np.array(self._field.shape) // size)
        free = np.zeros(shape, bool)
        inside = ((blocks >= 0) & (blocks < shape[::-1])).all(axis=1)
        free[blocks[inside, 1], blocks[inside, 0]] = True
        return free


def _best_of_blocks(field: np.ndarray, size: int) -> np.ndarray:
    """Return for every cell the best of the `size` x `size` cells from it on."""
    kernel = np.ones((size + 1, size + 1), np.uint8)
    return np.asarray(cv2.dilate(field, kernel, anchor=(0, 0)))


def _apart(peaks: list[Peak], share: float, num: int) -> list[Peak]:
    """Return peaks, the best first, none near a better one or below its share of the best."""
    kept: list[Peak] = []
    for peak in sorted(peaks, key=lambda peak: -peak.score):
        if kept and peak.score < share * kept[0].score:
            break
        if all(not is_same_peak(peak.pose, other.pose) for other in kept):
            kept.append(peak)
    return kept[:num]


@numba.njit(cache=True)
def _score_blocks(field, nodes, size, query, turns):  # type: ignore[no-untyped-def]
    """Return the mean score of points (cells) at blocks (turn, row, col), shape (N,)."""
    rows, cols = field.shape
    turned = np.empty((len(turns), len(query), 2))
    for k in range(len(turns)):
        c, s = np.cos(turns[k]), np.sin(turns[k])
        for i in range(len(query)):
            turned[k, i, 0] = c * query[i, 0] - s * query[i, 1]
            turned[k, i, 1] = s * query[i, 0] + c * query[i, 1]
    scores = np.zeros(len(nodes))
    for n in range(len(nodes)):
        k, y, x = nodes[n, 0], nodes[n, 1] * size, nodes[n, 2] * size
        total = 0.0
        for i in range(len(query)):
            row = int(np.floor(y + turned[k, i, 1]))
            col = int(np.floor(x + turned[k, i, 0]))
            if 0 <= row < rows and 0 <= col < cols:
                total += field[row, col]
        scores[n] = total / len(query)
    return scores
