"""The robots' layout but for place, turn and size, triangle by triangle (team paper, 3.2.3).

A first triangle that both constraints allow is the base; robots join it along its edges, one
triangle each, and every new edge is looked at in turn. A layout is there as soon as the base
triangle is, and grows from then on: whoever needs it early takes what `grow` has yielded so far.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from multi_localizer.team_problem import TeamProblem
from multi_localizer.triangle_search import base_triangle, on_edge


@dataclass(frozen=True, eq=False)
class RelativeLayout:
    """A layout in the frame of its first robot's view of its second one, 1 long.

    Attributes:
        robots: In the order they were placed.
        places: Positions, (N, 2); NaN where a robot is not placed.
        yaws: (N,), rad; NaN likewise.
        owner: Robot that each ray was found to lead to, (M,); -1 for none.
        num_triangles: Triangles found.
    """

    robots: tuple[int, ...]
    places: np.ndarray
    yaws: np.ndarray
    owner: np.ndarray
    num_triangles: int


class _Growth:
    """What has been found so far; filled by the functions below."""

    def __init__(self, problem: TeamProblem, tolerance: float) -> None:
        self.problem = problem
        self.tolerance = tolerance
        self.rough = np.ascontiguousarray(problem.prior[:, :2])
        self.clear()

    def clear(self) -> None:
        """Begin anew."""
        n = self.problem.num_robots
        self.robots: list[int] = []
        self.places = np.full((n, 2), np.nan)
        self.yaws = np.full(n, np.nan)
        self.owner = np.full(len(self.problem.bearings), -1, dtype=np.int64)
        self.towards = np.full((n, n), -1, dtype=np.int64)
        self.num_triangles = 0

    def layout(self) -> RelativeLayout:
        """Return what there is, not to change any more."""
        return RelativeLayout(
            tuple(self.robots), self.places.copy(), self.yaws.copy(), self.owner.copy(),
            self.num_triangles,
        )  # fmt: skip

    def note(self, a: int, ray: int, b: int) -> None:
        """Note that a ray of a leads to b."""
        self.owner[ray] = b
        self.towards[a, b] = ray

    def direction(self, a: int, ray: int) -> float:
        """Return where a ray of a placed robot points."""
        return float(self.yaws[a] + self.problem.bearings[ray])


def grow(problem: TeamProblem, tolerance: float) -> Iterator[RelativeLayout]:
    """Yield the layout whenever a triangle has been added (3.2.3 steps 3 to 6).

    Args:
        problem: The views; three robots or more for any layout.
        tolerance: dE, rad.
    """
    growth = _Growth(problem, tolerance)
    edges = _place_base(growth)
    if edges:
        yield growth.layout()
    while edges:
        a, b = edges.popleft()
        for c in range(problem.num_robots):
            if c in (a, b) or (growth.towards[a, c] >= 0 and growth.towards[b, c] >= 0):
                continue
            rays = on_edge(
                a, growth.towards[a, b], b, growth.towards[b, a], c, problem.start,
                problem.bearings, growth.rough, problem.has_prior, growth.owner, growth.towards,
                tolerance,
            )  # fmt: skip
            if rays[0] < 0 or not _add(growth, a, b, c, rays):
                continue
            edges.extend(((a, c), (b, c)))
            yield growth.layout()


def _place_base(growth: _Growth) -> deque[tuple[int, int]]:
    """Find the base triangle and place it (Fig. 5); return its edges."""
    problem = growth.problem
    for a, b, c in combinations(range(problem.num_robots), 3):
        ab, ba, bc, cb, ca, ac = base_triangle(
            a, b, c, problem.start, problem.bearings, growth.rough, problem.has_prior,
            growth.owner, growth.towards, growth.tolerance,
        )  # fmt: skip
        if ab < 0:
            continue
        growth.robots += [a, b]
        growth.places[a], growth.places[b] = (0.0, 0.0), (1.0, 0.0)
        growth.yaws[a] = -problem.bearings[ab]
        growth.yaws[b] = np.pi - problem.bearings[ba]
        growth.note(a, ab, b)
        growth.note(b, ba, a)
        if _add(growth, a, b, c, np.array([ac, bc, ca, cb])):
            return deque(((a, b), (b, c), (a, c)))
        growth.clear()
    return deque()


def _add(growth: _Growth, a: int, b: int, c: int, rays: np.ndarray) -> bool:
    """Add a triangle; place robot c where the rays of a and b meet if it has no place yet."""
    ac, bc, ca, cb = (int(ray) for ray in rays)
    if c not in growth.robots:
        place = crossing(
            growth.places[a], growth.direction(a, ac), growth.places[b], growth.direction(b, bc)
        )
        if place is None:
            return False
        growth.robots.append(c)
        growth.places[c] = place
        to_a = np.arctan2(*(growth.places[a] - place)[::-1])
        growth.yaws[c] = to_a - growth.problem.bearings[ca]
    for robot, ray, to in ((a, ac, c), (b, bc, c), (c, ca, a), (c, cb, b)):
        growth.note(robot, ray, to)
    growth.num_triangles += 1
    return True


def crossing(p: np.ndarray, along_p: float, q: np.ndarray, along_q: float) -> np.ndarray | None:
    """Return where two rays meet, (2,); None if they do not."""
    u = np.array([np.cos(along_p), np.sin(along_p)])
    v = np.array([np.cos(along_q), np.sin(along_q)])
    det = u[0] * v[1] - u[1] * v[0]
    if abs(det) < 1e-6:
        return None
    gap = q - p
    far_p = (gap[0] * v[1] - gap[1] * v[0]) / det
    far_q = (gap[0] * u[1] - gap[1] * u[0]) / det
    if far_p <= 0.0 or far_q <= 0.0:
        return None
    return np.asarray(p + far_p * u)
