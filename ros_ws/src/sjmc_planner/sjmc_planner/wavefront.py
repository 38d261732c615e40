"""The wave over a grid of weights, and the way down it (LaValle 2006, 8.2; thesis, Fig. 2.5).

The wave starts at the goal and gives each cell its cost to get there; with weights it is Dijkstra's
algorithm, eight neighbors a cell. The way goes from the start to the neighbor that makes the rest
cheapest, again and again; corners of the grid are then cut where the straight line costs no more.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.cell_heap import lift, take_first

_DIAGONAL = math.sqrt(2.0)
_AHEAD = 80  # cells of the way that one straight line may take the place of
_SAME = 1.0 + 1e-4


@numba.njit(cache=True, nogil=True)
def wave(weights, goal_row, goal_col, start_row, start_col):  # type: ignore[no-untyped-def]
    """Return each cell's cost to the goal, in cells of weight 1, shape (H, W); inf beyond.

    It stops once the start is reached: what is farther stays inf, or has too high a cost.

    Args:
        weights: Cost of each cell, shape (H, W); inf where nothing may go.
        goal_row: Where the wave begins.
        goal_col: Where the wave begins.
        start_row: Where it may end.
        start_col: Where it may end.
    """
    height, width = weights.shape
    grid = np.full((height, width), np.inf)
    cost = grid.ravel()
    order, place = np.empty(height * width, dtype=np.int64), np.full(height * width, -1)
    first = goal_row * width + goal_col
    cost[first], order[0], place[first] = 0.0, first, 0
    num = 1
    while num > 0:
        cell = take_first(cost, order, place, num)
        num -= 1
        row, col = cell // width, cell % width
        if row == start_row and col == start_col:
            break
        for i in range(-1, 2):
            for j in range(-1, 2):
                r, c = row + i, col + j
                step = _step_cost(weights, row, col, r, c)
                if step == np.inf:
                    continue
                other = r * width + c
                new = cost[cell] + step
                if new < cost[other]:
                    cost[other] = new
                    if place[other] < 0:
                        place[other] = num
                        order[num] = other
                        num += 1
                    lift(cost, order, place, place[other])
    return grid


@numba.njit(cache=True, nogil=True)
def _step_cost(weights, row, col, r, c):  # type: ignore[no-untyped-def]
    """Return the cost of a step to a neighbor: its length by the mean of the two cells' weights.

    A step off the grid, onto a closed cell or past a closed corner, or to the cell itself, is inf.
    """
    if r < 0 or c < 0 or r >= weights.shape[0] or c >= weights.shape[1]:
        return np.inf
    is_open = weights[r, c] < np.inf and weights[row, c] < np.inf and weights[r, col] < np.inf
    if not is_open or (r == row and c == col):
        return np.inf
    step = _DIAGONAL if r != row and c != col else 1.0
    return step * 0.5 * (weights[row, col] + weights[r, c])


@numba.njit(cache=True, nogil=True)
def way_down(cost, weights, row, col):  # type: ignore[no-untyped-def]
    """Return the cells from a start down to the goal, shape (K, 2); empty if it cannot be reached.

    Args:
        cost: From `wave`.
        weights: What it was made from.
        row: The start.
        col: The start.
    """
    if not cost[row, col] < np.inf:
        return np.zeros((0, 2), dtype=np.int64)
    cells = [(row, col)]
    while cost[row, col] > 0.0:
        best, best_row, best_col = np.inf, row, col
        for i in range(-1, 2):
            for j in range(-1, 2):
                r, c = row + i, col + j
                step = _step_cost(weights, row, col, r, c)
                if step == np.inf:
                    continue
                total = cost[r, c] + step
                if cost[r, c] < cost[row, col] and total < best:
                    best, best_row, best_col = total, r, c
        row, col = best_row, best_col
        cells.append((row, col))
    found = np.empty((len(cells), 2), dtype=np.int64)
    for k in range(len(cells)):
        found[k, 0], found[k, 1] = cells[k]
    return found


@numba.njit(cache=True, nogil=True)
def line_cost(weights, a, b):  # type: ignore[no-untyped-def]
    """Return what a straight line between two cells' middles costs; inf if it meets a closed one.

    Args:
        weights: Shape (H, W).
        a: (row, col) of one end.
        b: (row, col) of the other.
    """
    dr, dc = float(b[0] - a[0]), float(b[1] - a[1])
    length = np.sqrt(dr * dr + dc * dc)
    num = int(np.ceil(2.0 * length))
    total = 0.0
    for k in range(num):
        share = (k + 0.5) / num
        r, c = a[0] + share * dr, a[1] + share * dc
        total += weights[int(np.rint(r)), int(np.rint(c))]
    return total * length / max(num, 1)


@numba.njit(cache=True, nogil=True)
def cut_corners(cells, weights):  # type: ignore[no-untyped-def]
    """Return those cells of a way that straight lines, costing no more, can join, shape (C, 2).

    Args:
        cells: A way, shape (K, 2).
        weights: Shape (H, W).
    """
    num = len(cells)
    along = np.zeros(num)
    for k in range(1, num):
        along[k] = along[k - 1] + line_cost(weights, cells[k - 1], cells[k])
    kept = [0]
    i = 0
    while i < num - 1:
        best = i + 1
        for j in range(i + 2, min(i + _AHEAD, num - 1) + 1):
            if line_cost(weights, cells[i], cells[j]) <= (along[j] - along[i]) * _SAME:
                best = j
        i = best
        kept.append(i)
    return cells[np.array(kept)]


@numba.njit(cache=True, nogil=True)
def nearest_open(weights, row, col, reach):  # type: ignore[no-untyped-def]
    """Return the open cell nearest to a cell, (-1, -1) if there is none within `reach` cells."""
    best = reach * reach + 1e-9
    found = (-1, -1)
    most = int(np.ceil(reach))
    for r in range(max(row - most, 0), min(row + most + 1, weights.shape[0])):
        for c in range(max(col - most, 0), min(col + most + 1, weights.shape[1])):
            d2 = float((r - row) ** 2 + (c - col) ** 2)
            if weights[r, c] < np.inf and (d2 < best or (found[0] < 0 and d2 <= best)):
                best, found = d2, (r, c)
    return found
