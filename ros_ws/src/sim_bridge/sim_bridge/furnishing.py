"""Furniture for generated rooms: along the walls, clear of the door."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sim_bridge.world import Furniture

_WALL_M = 0.06  # half a wall
_GAP_M = 0.05
_DOOR_CLEAR = (1.6, 2.1)  # width and depth of what stays free before a door, m
_TRIES = 12
_CHAIR = (0.45, 0.45, 0.48)
# kind, name, size with its back to -x
_CATALOG = (
    ("table", "desk", (0.75, 1.5, 0.74)),
    ("shelf", "shelf", (0.35, 1.3, 1.9)),
    ("box", "cabinet", (0.5, 1.1, 1.2)),
    ("box", "sofa", (0.85, 1.8, 0.8)),
    ("table", "side table", (0.6, 0.6, 0.5)),
    ("box", "crate", (0.5, 0.6, 0.6)),
)


@dataclass(frozen=True)
class Room:
    """A room between the middle lines of its walls, m; its door is at its lower or upper side."""

    x0: float
    x1: float
    y0: float
    y1: float
    door_x: float
    has_low_door: bool


_Box = tuple[float, float, float, float]  # x0, x1, y0, y1


def furnish(room: Room, rng: np.random.Generator) -> Iterator[tuple[str, Furniture]]:
    """Yield furniture with its kind: `box`, `table` or `shelf`."""
    width, depth = _DOOR_CLEAR
    y = (room.y0, room.y0 + depth) if room.has_low_door else (room.y1 - depth, room.y1)
    taken: list[_Box] = [(room.door_x - width / 2.0, room.door_x + width / 2.0, *y)]
    num_items = int(rng.integers(3, 7))
    for _ in range(num_items):
        kind, name, size = _CATALOG[int(rng.integers(len(_CATALOG)))]
        for _try in range(_TRIES):
            center, yaw = _against_a_wall(room, size, rng)
            box = _box(center, size, yaw, ahead=0.6 if name == "desk" else 0.0)
            if _is_free(box, taken, room):
                taken.append(box)
                yield kind, Furniture(
                    name=name, center_m=center, size_m=size, yaw_deg=yaw,
                    surface="cloth" if name == "sofa" else "",
                )  # fmt: skip
                if name == "desk":
                    yield "table", _chair(center, yaw, rng)
                break


def _against_a_wall(
    room: Room, size: tuple[float, float, float], rng: np.random.Generator
) -> tuple[tuple[float, float], float]:
    """Return middle and yaw of an item whose back (-x) is at one of the four walls."""
    side, share = int(rng.integers(4)), float(rng.random())
    off, half = _WALL_M + _GAP_M + size[0] / 2.0, _WALL_M + _GAP_M + size[1] / 2.0
    along_y = room.y0 + half + share * max(room.y1 - room.y0 - 2.0 * half, 0.0)
    along_x = room.x0 + half + share * max(room.x1 - room.x0 - 2.0 * half, 0.0)
    places = (
        ((room.x0 + off, along_y), 0.0),
        ((along_x, room.y0 + off), 90.0),
        ((room.x1 - off, along_y), 180.0),
        ((along_x, room.y1 - off), 270.0),
    )
    (x, y), yaw = places[side]
    return (round(x, 3), round(y, 3)), yaw


def _chair(desk: tuple[float, float], yaw_deg: float, rng: np.random.Generator) -> Furniture:
    """Return a chair before a desk, turned a little."""
    a = np.radians(yaw_deg)
    x, y = desk[0] + 0.65 * np.cos(a), desk[1] + 0.65 * np.sin(a)
    turned = round(float(rng.uniform(-30.0, 30.0)), 1)
    center = (round(float(x), 3), round(float(y), 3))
    return Furniture(name="chair", center_m=center, size_m=_CHAIR, yaw_deg=turned)


def _box(
    center: tuple[float, float], size: tuple[float, float, float], yaw_deg: float, ahead: float
) -> _Box:
    """Return what an item takes up, with room `ahead` (m) of it; yaw is a multiple of 90."""
    a = np.radians(yaw_deg)
    forward = np.array([np.cos(a), np.sin(a)]).round()
    half = np.abs(forward) * size[0] / 2.0 + np.abs(forward[::-1]) * size[1] / 2.0
    low = np.minimum(np.array(center) - half, np.array(center) - half + ahead * forward)
    high = np.maximum(np.array(center) + half, np.array(center) + half + ahead * forward)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _is_free(box: _Box, taken: list[_Box], room: Room) -> bool:
    x0, x1, y0, y1 = box
    is_inside = x0 > room.x0 + _WALL_M and x1 < room.x1 - _WALL_M
    is_inside &= y0 > room.y0 + _WALL_M and y1 < room.y1 - _WALL_M
    return is_inside and all(
        x1 + _GAP_M < t[0] or t[1] + _GAP_M < x0 or y1 + _GAP_M < t[2] or t[3] + _GAP_M < y0
        for t in taken
    )
