"""A heap of cells by cost, each in it once: what the wave's front needs, compiled.

`order` holds the cells of the heap, `place` each cell's index in it (-1: not in it).
"""

from __future__ import annotations

import numba


@numba.njit(cache=True, nogil=True)
def lift(cost, order, place, i):  # type: ignore[no-untyped-def]
    """Move the cell at index `i` up to where its cost belongs."""
    cell = order[i]
    while i > 0:
        parent = (i - 1) // 2
        if cost[order[parent]] <= cost[cell]:
            break
        order[i] = order[parent]
        place[order[i]] = i
        i = parent
    order[i] = cell
    place[cell] = i


@numba.njit(cache=True, nogil=True)
def take_first(cost, order, place, num):  # type: ignore[no-untyped-def]
    """Take the cheapest of `num` cells out and return it."""
    first, last = order[0], order[num - 1]
    place[first] = -1
    num -= 1
    i = 0
    while 2 * i + 1 < num:
        child = 2 * i + 1
        if child + 1 < num and cost[order[child + 1]] < cost[order[child]]:
            child += 1
        if cost[last] <= cost[order[child]]:
            break
        order[i] = order[child]
        place[order[i]] = i
        i = child
    if num > 0:
        order[i] = last
        place[last] = i
    return first
