"""The triangle constraint of the team paper (3.2.1): three robots' angles add up to 180 degrees.

A robot sees two others under an angle, the difference of two bearings folded into 0..180 degrees.
Three robots A, B, C that go counter-clockwise see each other so that, counter-clockwise,

    at A the ray to B comes before the ray to C, at B C before A, at C A before B,

each less than half a turn before. With the other orientation every order is reversed.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.team_normal import wrap


@numba.njit(cache=True, inline="always")
def folded(a: float, b: float) -> float:
    """Return the angle between two bearings, 0..pi (3.2.3 step 2)."""
    return abs(wrap(a - b))


@numba.njit(cache=True, inline="always")
def makes_triangle(at_a: float, at_b: float, at_c: float, tolerance: float) -> bool:
    """Return whether three angles add up to pi within the tolerance dE (3.2.3 step 3)."""
    return abs(at_a + at_b + at_c - np.pi) <= tolerance


@numba.njit(cache=True, inline="always")
def is_ordered(first: float, second: float, turn: float) -> bool:
    """Return whether, turning by the sign of `turn`, the first bearing comes before the second."""
    return wrap(second - first) * turn > 0.0


@numba.njit(cache=True)
def orientation(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Return 1 if three positions go counter-clockwise, else -1."""
    cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return 1.0 if cross >= 0.0 else -1.0


def angles_between(bearings: np.ndarray) -> np.ndarray:
    """Return the angles between all pairs of a robot's bearings, (K,), 0..pi (3.2.3 step 2)."""
    i, j = np.triu_indices(len(bearings), 1)
    return np.asarray(np.abs((bearings[i] - bearings[j] + np.pi) % (2.0 * np.pi) - np.pi))


@numba.njit(cache=True)
def count_sums(angles: np.ndarray, start: np.ndarray, tolerance: float, most_triples: int) -> int:
    """Check the angles of all triples of robots, as Kato et al. (1999) did; return how many hold.

    Args:
        angles: Between the bearings of each robot, all robots behind each other, (A,).
        start: Where each robot's angles begin, (N + 1,).
        tolerance: dE, rad.
        most_triples: Triples of robots checked at most.
    """
    num, found, triples = len(start) - 1, 0, 0
    for p in range(num):
        for q in range(p + 1, num):
            for r in range(q + 1, num):
                if triples >= most_triples:
                    return found
                triples += 1
                for a in range(start[p], start[p + 1]):
                    for b in range(start[q], start[q + 1]):
                        for c in range(start[r], start[r + 1]):
                            found += makes_triangle(angles[a], angles[b], angles[c], tolerance)
    return found
