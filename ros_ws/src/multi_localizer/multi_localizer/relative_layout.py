"""The robots' layout but for place, turn and size, triangle by triangle (team paper, 3.2.3).

A first triangle that both constraints allow is the base; robots join it along its edges, one
triangle each, and every new edge is looked at in turn. Where no edge is left, the triples that are
not yet joined are gone through for another base (step 6), so that every combination is verified;
what grows from it is a part of its own, with a size of its own. The part with most robots is the
layout. One is there as soon as the base triangle is, and grows from then on: whoever needs it
early takes what `grow` has yielded so far.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from multi_localizer.rays import crossing
from multi_localizer.team_problem import TeamProblem
from multi_localizer.triangle_search import base_triangle, on_edge


@dataclass(frozen=True, eq=False)
class RelativeLayout:
    """A layout in the frame of its first robot's view of its second one, 1 long.

    Attributes:
        robots: In the order they were placed.
        places: Positions, (N, 2); NaN where a robot is not placed.
        yaws: (N,), rad; NaN likewise.
        owner: Robot that each ray was found to lead to, in whichever part, (M,); -1 for none.
        num_triangles: Triangles found, of all parts.
    """

    robots: tuple[int, ...]
    places: np.ndarray
    yaws: np.ndarray
    owner: np.ndarray
    num_triangles: int


@dataclass(eq=False)
class _Part:
    """Robots that hang together by triangles."""

    places: np.ndarray
    yaws: np.ndarray
    robots: list[int] = field(default_factory=list)
    edges: deque[tuple[int, int]] = field(default_factory=deque)


class _Growth:
    """What has been found so far; filled by the functions below."""

    def __init__(self, problem: TeamProblem, tolerance: float) -> None:
        n = problem.num_robots
        self.problem = problem
        self.tolerance = tolerance
        self.rough = np.ascontiguousarray(problem.prior[:, :2])
        self.owner = np.full(len(problem.bearings), -1, dtype=np.int64)
        self.towards = np.full((n, n), -1, dtype=np.int64)
        self.parts: list[_Part] = []
        self.num_triangles = 0

    def layout(self) -> RelativeLayout:
        """Return the part with most robots, not to change any more."""
        part = max(self.parts, key=lambda part: len(part.robots))
        return RelativeLayout(
            tuple(part.robots), part.places.copy(), part.yaws.copy(), self.owner.copy(),
            self.num_triangles,
        )  # fmt: skip

    def is_done(self, *robots: int) -> bool:
        """Return whether each of some robots has been found in the view of each other."""
        return all(self.towards[a, b] >= 0 for a in robots for b in robots if a != b)

    def note(self, a: int, ray: int, b: int) -> None:
        """Note that a ray of a leads to b."""
        self.owner[ray] = b
        self.towards[a, b] = ray


def grow(problem: TeamProblem, tolerance: float) -> Iterator[RelativeLayout]:
    """Yield the layout whenever a triangle has been added (3.2.3 steps 3 to 6).

    Args:
        problem: The views; three robots or more for any layout.
        tolerance: dE, rad.
    """
    growth = _Growth(problem, tolerance)
    for triple in combinations(range(problem.num_robots), 3):
        part = None if growth.is_done(*triple) else _new_part(growth, *triple)
        if part is None:
            continue
        yield growth.layout()
        while part.edges:
            a, b = part.edges.popleft()
            for c in range(problem.num_robots):
                if c not in (a, b) and _join(growth, part, a, b, c):
                    yield growth.layout()


def _join(growth: _Growth, part: _Part, a: int, b: int, c: int) -> bool:
    """Add a triangle of an edge and another robot if one holds (step 5)."""
    problem, towards = growth.problem, growth.towards
    if growth.is_done(a, b, c) and c in part.robots:
        return False
    rays = on_edge(
        a, towards[a, b], b, towards[b, a], c, problem.start, problem.bearings, growth.rough,
        problem.has_prior, growth.owner, towards, growth.tolerance,
    )  # fmt: skip
    return bool(rays[0] >= 0) and _add(growth, part, a, b, c, rays)


def _new_part(growth: _Growth, a: int, b: int, c: int) -> _Part | None:
    """Return a part of one base triangle (Fig. 5), with its edges; None if none holds."""
    problem, n = growth.problem, growth.problem.num_robots
    ab, ba, bc, cb, ca, ac = base_triangle(
        a, b, c, problem.start, problem.bearings, growth.rough, problem.has_prior,
        growth.owner, growth.towards, growth.tolerance,
    )  # fmt: skip
    if ab < 0:
        return None
    part = _Part(np.full((n, 2), np.nan), np.full(n, np.nan), [a, b])
    part.places[a], part.places[b] = (0.0, 0.0), (1.0, 0.0)
    part.yaws[a] = -problem.bearings[ab]
    part.yaws[b] = np.pi - problem.bearings[ba]
    growth.parts.append(part)
    if not _add(growth, part, a, b, c, np.array([ac, bc, ca, cb])):
        growth.parts.pop()
        return None
    growth.note(a, ab, b)
    growth.note(b, ba, a)
    part.edges.appendleft((a, b))
    return part


def _add(growth: _Growth, part: _Part, a: int, b: int, c: int, rays: np.ndarray) -> bool:
    """Add a triangle; place robot c where the rays of a and b meet if it has no place yet."""
    ac, bc, ca, cb = (int(ray) for ray in rays)
    bearings = growth.problem.bearings
    if c not in part.robots:
        place = crossing(
            part.places[a], part.yaws[a] + bearings[ac], part.places[b], part.yaws[b] + bearings[bc]
        )
        if place is None:
            return False
        part.robots.append(c)
        part.places[c] = place
        part.yaws[c] = np.arctan2(*(part.places[a] - place)[::-1]) - bearings[ca]
    for robot, ray, to in ((a, ac, c), (b, bc, c), (c, ca, a), (c, cb, b)):
        growth.note(robot, ray, to)
    part.edges.extend(((a, c), (b, c)))
    growth.num_triangles += 1
    return True
