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


@numba.njit(cache=True)
def count_triangles(start: np.ndarray, bearings: np.ndarray, tolerance: float) -> tuple[int, int]:
    """Check every triangle of every three robots, as Kato et al. (1999) did.

    Args:
        start: Where each robot's bearings begin, (N + 1,).
        bearings: Of all robots, (M,), rad.
        tolerance: dE, rad.

    Returns:
        Number of combinations of angles checked, and of those that hold.
    """
    n = len(start) - 1
    checked, held = 0, 0
    for p in range(n):
        for q in range(p + 1, n):
            for r in range(q + 1, n):
                for a in range(start[p], start[p + 1]):
                    for a2 in range(a + 1, start[p + 1]):
                        at_p = folded(bearings[a], bearings[a2])
                        for b in range(start[q], start[q + 1]):
                            for b2 in range(b + 1, start[q + 1]):
                                at_q = folded(bearings[b], bearings[b2])
                                for c in range(start[r], start[r + 1]):
                                    for c2 in range(c + 1, start[r + 1]):
                                        at_r = folded(bearings[c], bearings[c2])
                                        checked += 1
                                        if makes_triangle(at_p, at_q, at_r, tolerance):
                                            held += 1
    return checked, held
