"""Seeded indoor floors: rooms along one or two corridors, doors, furniture, a share of glass.

The share is that of the inner walls' length, doors left out; outer walls are opaque. Glass comes in
frames. The same seed gives the same rooms and furniture whatever the share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_bridge.furnishing import Room, furnish
from sim_bridge.glass import Frame, Glass
from sim_bridge.places import Route
from sim_bridge.schema import WorldError
from sim_bridge.world import Furniture, Point, RobotPlacement, Wall, World

OUTER_WALLS = 4  # the first of a generated world's walls
_DOOR_M = 1.2
_SHORTEST_PIECE_M = 0.15
_CLEAR_M = 1.3  # how far a route goes into a room
_NAME = "generated:SEED:GLASS_SHARE"


@dataclass(frozen=True)
class _Plan:
    """Rooms of a floor and the middle lines of its corridors."""

    width: float
    depth: float
    rooms: tuple[Room, ...]
    corridors_y: tuple[float, ...]
    corridor_width: float


def generated_world(name: str) -> World:
    """Return the floor that a name such as `generated:7:0.3` stands for.

    Raises:
        WorldError: The name is not of that form.
    """
    parts = name.split(":")
    try:
        if len(parts) != 3 or parts[0] != "generated":
            raise ValueError
        return generate_floor(int(parts[1]), float(parts[2]))
    except WorldError:
        raise
    except ValueError as error:
        raise WorldError(f"expected {_NAME}, such as generated:7:0.3, got {name!r}") from error


def generate_floor(seed: int, glass_share: float) -> World:
    """Return a furnished floor with a robot and a route through corridors and rooms.

    Args:
        seed: Any whole number >= 0.
        glass_share: Share of the inner walls' length that is glass, 0..1.

    Raises:
        WorldError: A value outside its range.
    """
    if seed < 0 or not 0.0 <= glass_share <= 1.0:
        raise WorldError(
            f"seed must be >= 0 and glass share in 0..1, got {seed} and {glass_share:g}"
        )
    streams = np.random.SeedSequence([seed]).spawn(4)
    rng_plan, rng_glass, rng_furniture, rng_route = map(np.random.default_rng, streams)
    plan = _plan(rng_plan)
    walls = [*_outer_walls(plan), *_glazed(_inner_walls(plan), glass_share, rng_glass)]
    items: dict[str, list[Furniture]] = {"box": [], "table": [], "shelf": []}
    for room in plan.rooms:
        for kind, item in furnish(room, rng_furniture):
            items[kind].append(item)
    y = plan.corridors_y[0]
    robot = RobotPlacement(model="segway_rmp50", position_m=(1.2, y))
    return World(
        name=f"generated-{seed}-{glass_share:g}",
        description=f"Generated floor, {len(plan.rooms)} rooms, {100 * glass_share:g} % glass",
        walls=tuple(walls),
        boxes=tuple(items["box"]),
        tables=tuple(items["table"]),
        shelves=tuple(items["shelf"]),
        robots=(robot,),
        route=Route(waypoints_m=_route(plan, rng_route), speed_m_s=0.8),
    )


def _plan(rng: np.random.Generator) -> _Plan:
    """Draw rows of rooms with corridors between; two corridors are joined at both ends."""
    width, corridor = float(rng.uniform(13.0, 24.0)), float(rng.uniform(1.9, 2.6))
    num_corridors = int(rng.integers(1, 3))
    depths = rng.uniform(3.6, 5.6, num_corridors + 1)
    rooms, corridors_y, y = [], [], 0.0
    for row, depth in enumerate(depths):
        is_middle = 0 < row < num_corridors
        # The row between two corridors leaves both ends free.
        low, high = (corridor, width - corridor) if is_middle else (0.0, width)
        cuts = _cuts(low, high, rng)
        has_low_door = row == num_corridors or (is_middle and bool(rng.integers(2)))
        for x0, x1 in zip(cuts[:-1], cuts[1:], strict=True):
            door = float(rng.uniform(x0 + 0.9, x1 - 0.9))
            rooms.append(Room(x0, x1, y, y + float(depth), door, has_low_door))
        y += float(depth)
        if row < num_corridors:
            corridors_y.append(y + corridor / 2.0)
            y += corridor
    return _Plan(width, y, tuple(rooms), tuple(corridors_y), corridor)


def _cuts(low: float, high: float, rng: np.random.Generator) -> list[float]:
    """Return where rooms of about 3 to 6 m begin and end."""
    num = max(1, round((high - low) / float(rng.uniform(3.6, 5.2))))
    parts = rng.uniform(0.8, 1.25, num)
    ends = low + (high - low) * np.cumsum(parts) / parts.sum()
    return [low, *(float(end) for end in ends[:-1]), high]


def _outer_walls(plan: _Plan) -> list[Wall]:
    corners = [(0.0, 0.0), (plan.width, 0.0), (plan.width, plan.depth), (0.0, plan.depth)]
    return [
        Wall(from_m=a, to_m=b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]


def _inner_walls(plan: _Plan) -> list[tuple[Point, Point]]:
    """Return the pieces of the inner walls, doors left out: each side of a room once."""
    pieces: list[tuple[Point, Point]] = []
    for room in plan.rooms:
        for y, has_door in ((room.y0, room.has_low_door), (room.y1, not room.has_low_door)):
            if not 0.0 < y < plan.depth:
                continue
            gap = (room.door_x - _DOOR_M / 2.0, room.door_x + _DOOR_M / 2.0)
            cuts = [room.x0, *(gap if has_door else ()), room.x1]
            pieces += [((a, y), (b, y)) for a, b in zip(cuts[::2], cuts[1::2], strict=True)]
        # Its left side; the last room of a row that ends at a corridor has a right side too.
        if room.x0 > 0.0:
            pieces.append(((room.x0, room.y0), (room.x0, room.y1)))
        is_last = not any(r.y0 == room.y0 and r.x0 == room.x1 for r in plan.rooms)
        if is_last and room.x1 < plan.width:
            pieces.append(((room.x1, room.y0), (room.x1, room.y1)))
    return pieces


def _glazed(
    pieces: list[tuple[Point, Point]], share: float, rng: np.random.Generator
) -> list[Wall]:
    """Return the walls; pieces drawn by seed are glass until the share is met, the last in part."""
    lengths = np.array([np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in pieces])
    left, walls = share * float(lengths.sum()), []
    for k in rng.permutation(len(pieces)):
        (a, b), part = pieces[k], min(left / lengths[k], 1.0)
        spacing = float(rng.choice([0.0, 1.0, 1.2, 1.5]))
        material = Glass(thickness_m=float(rng.choice([0.006, 0.008, 0.010, 0.012])))
        left -= part * lengths[k]
        # Too short a rest is not worth a piece of its own.
        part = round(part) if min(part, 1.0 - part) * lengths[k] < _SHORTEST_PIECE_M else part
        middle = (a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]))
        if part > 0.0:
            frame = Frame(spacing_m=spacing, width_m=0.05, depth_m=0.06, rail_m=0.06)
            walls.append(Wall(from_m=a, to_m=middle, glass=material, frame=frame))
        if part < 1.0:
            walls.append(Wall(from_m=middle, to_m=b))
    return walls


def _route(plan: _Plan, rng: np.random.Generator) -> tuple[Point, ...]:
    """Return a way along the corridors and back, into about half of the rooms."""
    visited = [room for room in plan.rooms if rng.random() < 0.6] or [plan.rooms[0]]
    points: list[Point] = []
    for k, y in enumerate(plan.corridors_y):
        is_back = k % 2 == 1
        edge = plan.corridor_width / 2.0
        here = [r for r in visited if abs((r.y0 if r.has_low_door else r.y1) - y) < edge + 0.1]
        for room in sorted(here, key=lambda room: room.door_x, reverse=is_back):
            side = 1.0 if room.has_low_door else -1.0
            inside = (room.door_x, y + side * (edge + _CLEAR_M))
            at_door = (room.door_x, y + side * edge)
            points += [(room.door_x, y), at_door, inside, at_door, (room.door_x, y)]
        if len(plan.corridors_y) > 1:
            end = edge if is_back else plan.width - edge
            points += [(end, y), (end, plan.corridors_y[1 - k])]
    points += [(plan.corridor_width / 2.0, plan.corridors_y[0]), (1.6, plan.corridors_y[0])]
    return tuple((round(x, 3), round(y, 3)) for x, y in points)
