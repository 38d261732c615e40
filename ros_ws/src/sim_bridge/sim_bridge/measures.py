"""Named lengths and angles of a world, for comparing with a map of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Measure:
    """A length between two points of surfaces, or with `corner_m` the angle there between them."""

    name: str
    from_m: Point
    to_m: Point
    corner_m: Point | None = None
    doc: str = ""

    def __post_init__(self) -> None:
        ends = (self.from_m, self.to_m)
        pairs = [ends] if self.corner_m is None else [(self.corner_m, end) for end in ends]
        if any(math.dist(a, b) < 1e-6 for a, b in pairs):
            raise ValueError(f"measure {self.name!r} has points that coincide")

    @property
    def unit(self) -> str:
        """`m` for a length, `deg` for an angle."""
        return "m" if self.corner_m is None else "deg"

    @property
    def value(self) -> float:
        """The length in meters or the angle in degrees, 0..180."""
        if self.corner_m is None:
            return math.dist(self.from_m, self.to_m)
        (x, y), (x0, y0), (x1, y1) = self.corner_m, self.from_m, self.to_m
        turn = math.atan2(y1 - y, x1 - x) - math.atan2(y0 - y, x0 - x)
        return math.degrees(abs(math.remainder(turn, 2.0 * math.pi)))
