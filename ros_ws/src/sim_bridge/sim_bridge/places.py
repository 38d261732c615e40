"""Where in a world file a robot is to drive: along a route, or to goals."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Route:
    """Waypoints in the world that the demo drives through, and how fast."""

    waypoints_m: tuple[Point, ...]
    speed_m_s: float = 0.8

    def __post_init__(self) -> None:
        _require(self.speed_m_s, "waypoints_m", self.waypoints_m)


@dataclass(frozen=True, kw_only=True)
class Goals:
    """Places in the world that the demo sends a robot to, one after the other, and how fast."""

    points_m: tuple[Point, ...]
    speed_m_s: float = 0.6

    def __post_init__(self) -> None:
        _require(self.speed_m_s, "points_m", self.points_m)


def _require(speed: float, name: str, points: tuple[Point, ...]) -> None:
    if not speed > 0.0:
        raise ValueError(f"speed_m_s must be > 0, got {speed:g}")
    if not points:
        raise ValueError(f"{name} must hold a place, got none")
