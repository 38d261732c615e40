"""Rooms and offices with glass walls and doors, drawn by seed, and goals on both sides of glass.

Even numbers are a room that a screen divides, odd ones a corridor with rooms behind fronts, mostly
of glass. Every screen and front has an open doorway; opaque ones have a shut glass door too. On
the straight line from the start the first goal lies behind glass; the last one is beside a pane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from experiments.glass_paths import crossings
from experiments.glass_truth import pane_lines
from sim_bridge.glass import Frame, Glass
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import Column, Door, Furniture, Point, RobotPlacement, Wall, World

ROBOT_MODEL = "segway_rmp50"
_DOORWAY_M, _SHUT_M = 1.8, 1.0
_CLEAR_M = 0.95  # from a start or a goal to anything
_BESIDE_M = 1.25  # the last goal is no farther than this from glass
_APART_M = 2.5  # from place to place
_TRIES = 4000
_POST = 0.15  # a shorter piece of wall is left out, m


@dataclass(frozen=True)
class Place:
    """Where one drive takes place.

    Attributes:
        world: With the robot at its start.
        goals: To be visited in this order, in the world, m.
        kind: `room` or `office`.
    """

    world: World
    goals: tuple[Point, ...]
    kind: str


def place_of(seed: int, number: int) -> Place:
    """Return the place of a run; the same seed and number give the same place."""
    rng = np.random.default_rng([seed, number])
    kind = "office" if number % 2 else "room"
    for _ in range(_TRIES):
        world = _office(rng) if number % 2 else _room(rng)
        ends = _ends(world, rng)
        if ends is None:
            continue
        start, *goals = ends
        yaw = float(rng.uniform(-180.0, 180.0))
        robot = RobotPlacement(model=ROBOT_MODEL, position_m=start, yaw_deg=yaw)
        named = replace(world, name=f"{kind}-{seed}-{number}", robots=(robot,))
        return Place(named, tuple(goals), kind)
    raise RuntimeError(f"no place found for seed {seed}, number {number}")


def _room(rng: np.random.Generator) -> World:
    """Return a room of two parts, with a screen between that has an open and a shut doorway."""
    width, depth = float(rng.uniform(8.0, 10.0)), float(rng.uniform(6.0, 7.5))
    x = width * float(rng.uniform(0.42, 0.58))
    walls = [*_border(width, depth), *_screen((x, 0.06), (x, depth - 0.06), rng, 0.8)]
    return World(name="room", walls=tuple(walls), **_furniture(width, depth, rng))


def _office(rng: np.random.Generator) -> World:
    """Return a corridor with two or three rooms on either side, most of them behind glass."""
    width, corridor = float(rng.uniform(9.0, 11.0)), float(rng.uniform(2.2, 2.6))
    depths = rng.uniform(3.4, 4.2, 2).tolist()
    low, high = depths[0], depths[0] + corridor
    depth = high + depths[1]
    walls = _border(width, depth)
    for y, (near, far) in ((low, (0.06, low)), (high, (high, depth - 0.06))):
        cuts = np.linspace(0.06, width - 0.06, int(rng.integers(2, 4)) + 1).tolist()
        for a, b in zip(cuts[:-1], cuts[1:], strict=True):
            walls += _screen((a, y), (b, y), rng, 0.8)
        for x in cuts[1:-1]:
            is_glass = bool(rng.random() < 0.5)
            walls += [_glass((x, near), (x, far), rng) if is_glass else _wall((x, near), (x, far))]
    return World(name="office", walls=tuple(walls), **_furniture(width, depth, rng))


def _border(width: float, depth: float) -> list[Wall]:
    corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    return [_wall(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def _wall(a: Point, b: Point) -> Wall:
    return Wall(from_m=a, to_m=b)


def _glass(a: Point, b: Point, rng: np.random.Generator) -> Wall:
    return Wall(from_m=a, to_m=b, glass=_pane(rng), frame=_frame(rng))


def _screen(a: Point, b: Point, rng: np.random.Generator, glass_share: float) -> list[Wall]:
    """Return a wall with an open doorway, glass or with a shut glass door in it."""
    length = math.dist(a, b)
    unit = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    low = float(rng.uniform(0.2, length - _DOORWAY_M - 0.2))
    is_glass = bool(rng.random() < glass_share)
    pieces = []
    for begin, end in ((0.0, low), (low + _DOORWAY_M, length)):
        if end - begin < _POST:
            continue
        from_m = (a[0] + begin * unit[0], a[1] + begin * unit[1])
        to_m = (a[0] + end * unit[0], a[1] + end * unit[1])
        if is_glass:
            pieces.append(_glass(from_m, to_m, rng))
            continue
        room = end - begin - _SHUT_M
        at = float(rng.uniform(0.1, max(room, 0.2) - 0.1)) + _SHUT_M / 2.0
        shut = Door(at_m=at, width_m=_SHUT_M, glass=_pane(rng), frame=Frame(width_m=0.08))
        pieces.append(Wall(from_m=from_m, to_m=to_m, doors=(shut,) if room > 0.2 else ()))
    return pieces


def _pane(rng: np.random.Generator) -> Glass:
    """Return glass from just cleaned to as dirty as the simulator's default."""
    thickness, dirt = rng.choice([0.006, 0.008, 0.010, 0.012]), rng.choice([0.002, 0.005, 0.02])
    return Glass(thickness_m=float(thickness), scatter_share=float(dirt))


def _frame(rng: np.random.Generator) -> Frame:
    spacing = float(rng.choice([0.0, 1.5, 2.0]))
    return Frame(spacing_m=spacing, width_m=0.05, depth_m=0.06, rail_m=0.06)


def _furniture(width: float, depth: float, rng: np.random.Generator) -> dict[str, tuple]:  # type: ignore[type-arg]
    """Return a few things along the outer walls."""
    boxes = []
    for name, size in (("cabinet", (0.9, 0.45, 1.2)), ("shelf", (1.0, 0.35, 1.8))):
        y = 0.06 + size[1] / 2.0 + 0.02
        x = float(rng.uniform(1.0, width - 1.0))
        boxes.append(Furniture(name=name, center_m=(x, y), size_m=size))
    x = float(rng.choice([0.45, width - 0.45]))
    plant = Column(name="plant", center_m=(x, depth - 0.45), radius_m=0.2, height_m=1.2)
    return {"boxes": tuple(boxes), "columns": (plant,)}


def _ends(world: World, rng: np.random.Generator) -> list[Point] | None:
    """Return start, a goal behind glass and one beside glass, or None if none were found."""
    solids = solids_of(world)
    panes, corners = pane_lines(solids), np.vstack([s.outline() for s in solids])
    low, high = corners.min(axis=0) + _CLEAR_M, corners.max(axis=0) - _CLEAR_M
    places = rng.uniform(low, high, (60, 2))
    places = places[_clearance(solids, places) >= _CLEAR_M]
    glass = [s for s in solids if s.glass is not None]
    if len(places) < 3 or not glass:
        return None
    start = places[0]
    is_far = np.hypot(*(places - start).T) > _APART_M
    is_behind = np.array([len(crossings(np.array([start, p]), panes)) > 0 for p in places])
    behind = places[is_far & is_behind]
    if not len(behind):
        return None
    beside = places[_clearance(glass, places) <= _BESIDE_M]
    beside = beside[np.hypot(*(beside - behind[0]).T) > _APART_M]
    if not len(beside):
        return None
    return [_point(start), _point(behind[0]), _point(beside[0])]


def _clearance(solids: list[Solid], places: np.ndarray) -> np.ndarray:
    return np.asarray(np.min([solid.signed_distance(places) for solid in solids], axis=0))


def _point(place: np.ndarray) -> Point:
    return round(float(place[0]), 3), round(float(place[1]), 3)
