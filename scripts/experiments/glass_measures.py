"""Lengths and angles measured from a map, by one rule for every map and every measure.

A measure's ends lie on surfaces of the world file. Each surface is a line fitted to the centers of
the occupied cells along it: those within 12 cm of the true face, its last 15 cm at both ends left
out, fitted by total least squares; cells farther than 8 cm from the line are then left out and it
is fitted again. For opaque surfaces cells that the map calls glass are left out. A length is the
distance of the shorter one's mean from the longer one; an angle is that between them. A post is
too short for a line: it is the mean of the occupied cells within 10 cm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floornav_common.grid import OccupancyMap
from grid_mapper.overlay import EVEN, on_cells_of
from sim_bridge.measures import Measure
from sim_bridge.solids import Solid

GATE_M, TRIM_M, REFIT_M = 0.12, 0.15, 0.08
POST_M = 0.10
JOIN_M = 0.10
_ON_M = 0.02
_FEWEST = 4
_IN_LINE_M = 0.01


@dataclass(frozen=True)
class Face:
    """A straight true surface: from `a` to `b`, shape (2,), m; a post where they are one point."""

    a: np.ndarray
    b: np.ndarray
    is_glass: bool

    @property
    def length(self) -> float:
        """M."""
        return math.dist(self.a, self.b)

    @property
    def direction(self) -> np.ndarray:
        """Unit vector along it, shape (2,)."""
        return np.asarray((self.b - self.a) / self.length)


@dataclass(frozen=True)
class Line:
    """A fitted line: mean of its cells, unit direction (a post has none), length of its face."""

    mean: np.ndarray
    direction: np.ndarray | None
    length: float


def measured(
    measure: Measure, solids: list[Solid], occupancy: OccupancyMap, glass: OccupancyMap | None
) -> float | None:
    """Return a length (m) or an angle (deg) as a map has it; None where it has too little of it.

    Args:
        measure: What to measure.
        solids: What truly stands at the height of the laser: says which cells belong to which
            surface.
        occupancy: The map.
        glass: What it says is glass, or None.
    """
    cells = occupancy.cells >= EVEN
    walls = cells if glass is None else cells & ~(on_cells_of(glass, occupancy) >= EVEN)
    points = {True: occupancy.to_points(np.argwhere(cells)),
              False: occupancy.to_points(np.argwhere(walls))}  # fmt: skip
    lines = []
    for face in faces_of(measure, solids):
        line = fitted(face, points[face.is_glass])
        if line is None:
            return None
        lines.append(line)
    return angle_between(*lines) if measure.corner_m is not None else distance_between(*lines)


def faces_of(measure: Measure, solids: list[Solid]) -> tuple[Face, Face]:
    """Return the true surfaces at a measure's ends; those of an angle meet in its corner."""
    ends = np.array(measure.from_m), np.array(measure.to_m)
    if measure.corner_m is None:
        along = (ends[1] - ends[0]) / math.dist(*ends)
        return tuple(face_at(end, np.array((-along[1], along[0])), solids) for end in ends)  # type: ignore[return-value]
    corner = np.array(measure.corner_m)
    arms = [(end - corner) / math.dist(end, corner) for end in ends]
    middles = [corner + 0.5 * (end - corner) for end in ends]
    return tuple(face_at(m, arm, solids) for m, arm in zip(middles, arms, strict=True))  # type: ignore[return-value]


def face_at(point: np.ndarray, direction: np.ndarray, solids: list[Solid]) -> Face:
    """Return the surface through a point along a direction, joined with those in line with it.

    Pieces of one kind join over gaps of up to 10 cm. A point inside something is a post there.

    Raises:
        ValueError: There is no surface.
    """
    edges = [
        (solid.glass is not None, a, b)
        for solid in solids
        for a, b in zip(solid.outline(), np.roll(solid.outline(), -1, axis=0), strict=True)
        if abs(_cross(b - a, direction)) < _IN_LINE_M * math.dist(a, b)
        and abs(_cross(a - point, direction)) < _ON_M
    ]
    at = [e for e in edges if _overlaps(*_span(e, point, direction), -_ON_M, _ON_M)]
    inside = [s for s in solids if s.glass is None and s.signed_distance(point[None])[0] < -_ON_M]
    if inside:
        return Face(point, point, is_glass=False)
    if not at:
        raise ValueError(f"no surface at {point.tolist()}")
    is_glass = at[0][0]
    low, high = _span(at[0], point, direction)
    for _ in edges:
        for edge in (e for e in edges if e[0] == is_glass):
            start, end = _span(edge, point, direction)
            if _overlaps(start, end, low - JOIN_M, high + JOIN_M):
                low, high = min(low, start), max(high, end)
    return Face(point + low * direction, point + high * direction, is_glass)


def fitted(face: Face, points: np.ndarray) -> Line | None:
    """Return the line through the cells along a face, by the rule above; None if too few.

    Args:
        face: The true surface.
        points: Centers of occupied cells, shape (N, 2), m.
    """
    off = points - face.a
    if face.length < 2.0 * TRIM_M:
        near = points[np.hypot(*off.T) <= POST_M]
        return Line(near.mean(axis=0), None, 0.0) if len(near) else None
    along, across = off @ face.direction, _cross(face.direction, off)
    is_near = (np.abs(across) <= GATE_M) & (along >= TRIM_M) & (along <= face.length - TRIM_M)
    near = points[is_near]
    if len(near) < _FEWEST:
        return None
    line = _total_least_squares(near, face)
    assert line.direction is not None
    kept = near[np.abs(_cross(line.direction, near - line.mean)) <= REFIT_M]
    return _total_least_squares(kept, face) if len(kept) >= _FEWEST else None


def distance_between(one: Line, other: Line) -> float:
    """Return the distance of two lines, m: of the mean of the shorter from the longer.

    So the direction of a short line, which is less certain, does not matter. Of two posts it is
    the distance of their means.
    """
    long, short = (one, other) if one.length >= other.length else (other, one)
    off = short.mean - long.mean
    if long.direction is None:
        return float(np.hypot(*off))
    return abs(float(_cross(long.direction, off)))


def angle_between(one: Line, other: Line) -> float:
    """Return the angle of two lines, deg, between 0 and 180; directions lead off the corner."""
    assert one.direction is not None and other.direction is not None
    return math.degrees(math.acos(np.clip(one.direction @ other.direction, -1.0, 1.0)))


def _total_least_squares(points: np.ndarray, face: Face) -> Line:
    """Return the line of least squared distances, its direction turned as the face's."""
    mean = points.mean(axis=0)
    _, vectors = np.linalg.eigh(np.cov((points - mean).T))
    along = vectors[:, 1]
    return Line(mean, along if along @ face.direction >= 0.0 else -along, face.length)


def _span(
    edge: tuple[bool, np.ndarray, np.ndarray], point: np.ndarray, direction: np.ndarray
) -> tuple[float, float]:
    ends = [float((end - point) @ direction) for end in edge[1:]]
    return min(ends), max(ends)


def _overlaps(start: float, end: float, low: float, high: float) -> bool:
    return end >= low and start <= high


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
