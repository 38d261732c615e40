"""How a world looks to cameras: its floor, its lamp (part of the schema of the YAML files)."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate

Color = tuple[float, float, float]
Point = tuple[float, float]
PATTERN_NAMES = ("books", "bricks", "grain", "paper", "stripes", "wood")


@dataclass(frozen=True, kw_only=True)
class Line:
    """A painted straight line, with square ends."""

    from_m: Point
    to_m: Point
    width_m: float = 0.01
    color: Color = (0.95, 0.95, 0.95)


@dataclass(frozen=True, kw_only=True)
class Ring:
    """A painted circle line; a width of twice the radius or more makes a disk."""

    center_m: Point
    radius_m: float
    width_m: float = 0.01
    color: Color = (0.95, 0.95, 0.95)


@dataclass(frozen=True, kw_only=True)
class Area:
    """A painted rectangle along the world's axes."""

    from_m: Point
    to_m: Point
    color: Color


@dataclass(frozen=True, kw_only=True)
class Dirt:
    """Stains thrown at random, always the same for a world."""

    count: int = 0
    size_m: float = 0.02
    color: Color = (0.25, 0.22, 0.18)
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Floor:
    """The floor: one color, and a picture on the part from `from_m` to `to_m`.

    `carpet` is the deviation of the picture's brightness, in parts of the color.
    """

    color: Color = (0.62, 0.60, 0.56)
    from_m: Point = (0.0, 0.0)
    to_m: Point = (0.0, 0.0)
    texel_m: float = param(0.0025, "Resolution of the picture.", unit="m", gt=0.0)
    carpet: float = param(0.03, "Deviation of its brightness.", ge=0.0, le=1.0)
    areas: tuple[Area, ...] = ()
    lines: tuple[Line, ...] = ()
    rings: tuple[Ring, ...] = ()
    dirt: Dirt = Dirt()

    def __post_init__(self) -> None:
        if self.texel_m <= 0.0 or not 0.0 <= self.carpet <= 1.0:
            raise ValueError(
                f"texel_m must be > 0 and carpet 0..1, got {self.texel_m}, {self.carpet}"
            )
        edges = [b - a for a, b in zip(self.from_m, self.to_m, strict=True)]
        if min(edges) < 0.0 or max(edges) / self.texel_m > 8192:
            raise ValueError(f"the floor picture must have 0 to 8192 texels an edge, got {edges} m")


@dataclass(frozen=True, kw_only=True)
class Light:
    """One distant lamp and light from everywhere; `color` tints both."""

    direction: tuple[float, float, float] = param((0.35, 0.25, 1.0), "From the floor to the lamp.")
    color: tuple[float, float, float] = param((1.0, 1.0, 1.0), "RGB factor.", ge=0.0, le=4.0)
    ambient: float = param(0.55, "Share of light from everywhere.", ge=0.0, le=1.0)
    shadow: float = param(0.6, "Share of the lamp's light that a shadow takes.", ge=0.0, le=1.0)

    def __post_init__(self) -> None:
        validate(self)
        if self.direction[2] <= 0.0:
            raise ValueError(f"direction must point up, got {self.direction}")


def require_pattern(name: str) -> None:
    """Check a texture's name.

    Raises:
        ValueError: There is none of that name.
    """
    if name and name not in PATTERN_NAMES:
        raise ValueError(f"no texture named {name!r}; there are: {', '.join(PATTERN_NAMES)}")
