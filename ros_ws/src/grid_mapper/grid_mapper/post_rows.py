"""Rows of posts that a front of glass may stand between.

Of glass that no sonar ever faced the laser sees the frame alone: posts in one line, evenly spaced.
"""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial import cKDTree

from floornav_common.se2 import SE2
from grid_mapper.pane_lines import PaneLine

MAX_POST_M = 0.25
"""A post's cells are no wider."""
MIN_BAY_M = 0.5
SAME_M = 0.08
"""Posts are in line and evenly spaced as well as this: their cells say no more."""


def post_rows(
    log_odds: np.ndarray, origin: SE2, resolution: float, max_bay: float
) -> list[PaneLine]:
    """Return the rows of three posts and more.

    Args:
        log_odds: Of the laser's cells, > 0 where opaque, shape (H, W).
        origin: Outer corner of cell (0, 0).
        resolution: Edge of a cell, m.
        max_bay: The farthest that posts of a row stand apart, m.
    """
    if not log_odds.size:
        return []
    posts = _posts(log_odds, resolution) + (origin.x, origin.y)
    if len(posts) < 3:
        return []
    tree = cKDTree(posts)
    pairs = tree.query_pairs(max_bay, output_type="ndarray")
    pairs = np.vstack((pairs, pairs[:, ::-1]))
    steps = posts[pairs[:, 1]] - posts[pairs[:, 0]]
    is_start = tree.query(posts[pairs[:, 0]] - steps)[0] > SAME_M
    goes_on = tree.query(posts[pairs[:, 1]] + steps)[0] <= SAME_M
    is_bay = np.hypot(*steps.T) >= MIN_BAY_M
    rows = [_row_from(posts, tree, a, b) for a, b in pairs[is_start & goes_on & is_bay].tolist()]
    return [_line_of(posts[row]) for row in sorted(rows) if len(row) >= 3 and row[0] < row[-1]]


def _posts(log_odds: np.ndarray, resolution: float) -> np.ndarray:
    """Return the middles of small opaque spots from the corner of the array, (N, 2) (x, y), m."""
    _, _, stats, centers = cv2.connectedComponentsWithStats(
        (log_odds > 0.0).astype(np.uint8), connectivity=8
    )
    size = np.maximum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    is_post = size * resolution <= MAX_POST_M + 1e-9
    is_post[0] = False  # the background
    return np.asarray((centers[is_post] + 0.5) * resolution)


def _row_from(posts: np.ndarray, tree: cKDTree, first: int, second: int) -> list[int]:
    """Return the posts that go on from two of them in the same steps."""
    row, step = [first, second], posts[second] - posts[first]
    while True:
        off, after = tree.query(posts[row[-1]] + step)
        if off > SAME_M or after in row:
            return row
        row.append(int(after))
        step = (posts[after] - posts[first]) / (len(row) - 1)


def _line_of(points: np.ndarray) -> PaneLine:
    """Return the line from the first of points in a row to the last."""
    x, y = points[-1] - points[0]
    theta = float(np.arctan2(-x, y))  # normal of a line along (-sin, cos)
    normal, way = np.array((np.cos(theta), np.sin(theta))), np.array((x, y)) / np.hypot(x, y)
    along = points @ way
    rho = float((points @ normal).mean())
    half = 0.5 * MAX_POST_M
    low, high = float(along[0]) - half, float(along[-1]) + half
    return PaneLine(theta, rho, np.empty(0, np.int64), low, high, np.inf)
