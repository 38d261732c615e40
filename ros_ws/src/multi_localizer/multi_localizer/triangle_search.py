"""Triangles of three robots, or on an edge that two have, that both constraints of the paper allow.

Rays are indices into the bearings of all robots. `towards[i, j]` is the ray of robot i that has
been found to lead to robot j, -1 if none has; `owner[k]` is the robot ray k leads to, or -1.
Which way round three robots go is taken from their rough positions (2.3: they are good enough for
the topology); without them both ways are tried.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.enumeration import holds
from multi_localizer.triangles import folded, is_ordered, makes_triangle, orientation


@numba.njit(cache=True)
def is_free(ray: int, robot: int, to: int, owner: np.ndarray, towards: np.ndarray) -> bool:
    """Return whether a ray of `robot` may lead to robot `to`, as far as is found."""
    return owner[ray] == to or (owner[ray] < 0 and towards[robot, to] < 0)


@numba.njit(cache=True)
def base_triangle(
    a: int, b: int, c: int, start: np.ndarray, bearings: np.ndarray, places: np.ndarray,
    has_place: np.ndarray, owner: np.ndarray, towards: np.ndarray, tolerance: float,
) -> np.ndarray:  # fmt: skip
    """Return the first triangle of three robots that holds: rays ab, ba, bc, cb, ca, ac; or -1s."""
    for ab in range(start[a], start[a + 1]):
        for ba in range(start[b], start[b + 1]):
            if not (is_free(ab, a, b, owner, towards) and is_free(ba, b, a, owner, towards)):
                continue
            if not holds(a, ab, b, ba, start, bearings, places, has_place):
                continue
            rays = on_edge(
                a, ab, b, ba, c, start, bearings, places, has_place, owner, towards, tolerance
            )
            if rays[0] >= 0:
                return np.array([ab, ba, rays[1], rays[3], rays[2], rays[0]])
    return np.full(6, -1)


@numba.njit(cache=True)
def on_edge(
    a: int, ab: int, b: int, ba: int, c: int, start: np.ndarray, bearings: np.ndarray,
    places: np.ndarray, has_place: np.ndarray, owner: np.ndarray, towards: np.ndarray,
    tolerance: float,
) -> np.ndarray:  # fmt: skip
    """Return rays ac, bc, ca, cb of the first triangle with edge a-b and robot c, or -1s.

    Args:
        a: A robot.
        ab: Its ray to b.
        b: A robot.
        ba: Its ray to a.
        c: The third.
        start: Where each robot's bearings begin, (N + 1,).
        bearings: Of all robots, (M,), rad.
        places: Rough positions, (N, 2), m.
        has_place: Which robots have one, (N,).
        owner: Robot each ray has been found to lead to, (M,).
        towards: Ray of each robot to each other, (N, N).
        tolerance: dE, rad.
    """
    knows = has_place[a] and has_place[b] and has_place[c]
    turn = orientation(places[a], places[b], places[c])
    for _ in range(1 if knows else 2):
        for ac in range(start[a], start[a + 1]):
            if ac == ab or not is_free(ac, a, c, owner, towards):
                continue
            if not is_ordered(bearings[ab], bearings[ac], turn):
                continue
            for bc in range(start[b], start[b + 1]):
                if bc == ba or not is_free(bc, b, c, owner, towards):
                    continue
                if not is_ordered(bearings[bc], bearings[ba], turn):
                    continue
                at_a = folded(bearings[ab], bearings[ac])
                at_b = folded(bearings[ba], bearings[bc])
                if at_a + at_b > np.pi + tolerance:
                    continue
                rays = _third(
                    a, ac, b, bc, c, at_a + at_b, turn, start, bearings, places, has_place, owner,
                    towards, tolerance,
                )  # fmt: skip
                if rays[0] >= 0:
                    return np.array([ac, bc, rays[0], rays[1]])
        turn = -turn
    return np.full(4, -1)


@numba.njit(cache=True)
def _third(
    a: int, ac: int, b: int, bc: int, c: int, at_both: float, turn: float, start: np.ndarray,
    bearings: np.ndarray, places: np.ndarray, has_place: np.ndarray, owner: np.ndarray,
    towards: np.ndarray, tolerance: float,
) -> tuple[int, int]:  # fmt: skip
    """Return the rays ca, cb that close a triangle, or -1s."""
    for ca in range(start[c], start[c + 1]):
        if not is_free(ca, c, a, owner, towards):
            continue
        for cb in range(start[c], start[c + 1]):
            if cb == ca or not is_free(cb, c, b, owner, towards):
                continue
            if not is_ordered(bearings[ca], bearings[cb], turn):
                continue
            at_c = folded(bearings[ca], bearings[cb])
            if (
                makes_triangle(at_both, 0.0, at_c, tolerance)
                and holds(a, ac, c, ca, start, bearings, places, has_place)
                and holds(b, bc, c, cb, start, bearings, places, has_place)
            ):
                return ca, cb
    return -1, -1
