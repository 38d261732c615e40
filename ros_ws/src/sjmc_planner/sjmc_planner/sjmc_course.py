"""Which course SJMC takes (thesis, 3.7): nearest the target's, without an obstacle in Danger."""

from __future__ import annotations

import functools

import numpy as np

_ROOM = 10.0  # m: farther is no freer
_OTHER_SIDE = 0.5  # rad: what a change of sides costs


def courses(target: float, step: float, widest: float) -> np.ndarray:
    """Return the courses that are weighed, nearest to the target's first, in (-pi, pi].

    Args:
        target: Bearing of the target, rad.
        step: Between two courses, rad.
        widest: The farthest from the target's, rad.

    Returns:
        Shape (2 K + 1,), rad: the target's, then one to the left and one to the right by turns.
    """
    around = target + _fan(step, widest)
    return np.asarray(np.pi - np.remainder(np.pi - around, 2.0 * np.pi))


@functools.cache
def _fan(step: float, widest: float) -> np.ndarray:
    """Return the courses off the target's, rad; the same ones at every decision."""
    off = step * np.arange(1, int(widest / step + 1e-9) + 1)
    fan = np.concatenate(([0.0], np.column_stack((off, -off)).ravel()))
    fan.setflags(write=False)
    return fan


def nearest_open(free: np.ndarray, danger: float, side: int = 0) -> int:
    """Return the first course without an obstacle in the Danger Zone; -1 if there is none.

    Args:
        free: How far each of `courses` is free, shape (2 K + 1,), m.
        danger: L_DANGER, m.
        side: 1 takes the left one of two that are as far off, -1 the right one, 0 the freer one.
    """
    open_ = np.flatnonzero(free > danger)
    if len(open_) == 0:
        return -1
    first = int(open_[0])
    if first == 0 or first % 2 == 0 or free[first + 1] <= danger:
        return first
    is_left = side > 0 or (side == 0 and free[first] >= free[first + 1])
    return first if is_left else first + 1


def preferred(bearings: np.ndarray, target: float, free: np.ndarray, side: int) -> np.ndarray:
    """Return the order in which `courses` are tried: nearest the target's, with a side kept.

    Args:
        bearings: Of `courses`, shape (2 K + 1,), rad.
        target: Bearing of the target, rad.
        free: How far each is free, shape (2 K + 1,), m.
        side: The side taken before, 1 for left, -1 for right; 0 for none.

    Returns:
        Indices, shape (2 K + 1,). Of two as far off the freer one is first.
    """
    num = len(bearings)
    rank = (np.arange(num) + 1) // 2
    sides = np.where(np.arange(num) % 2 == 1, 1, -1)
    sides[0] = side
    step = abs(np.remainder(bearings[1] - target + np.pi, 2.0 * np.pi) - np.pi) if num > 1 else 1.0
    cost = rank + (sides != side) * (abs(side) * _OTHER_SIDE / step)
    room = np.minimum(free, _ROOM)
    lean = float(room[1::2].sum() - room[2::2].sum())  # to the left of the target there is more
    return np.lexsort((-lean * sides, -free, np.round(cost, 6)))
