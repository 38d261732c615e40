"""The solids a world consists of, and their outline at a height (the truth a map is judged by)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.glass import Frame, Glass
from sim_bridge.surfaces import surface_of
from sim_bridge.world import Color, Furniture, Wall, World

_BOARD = 0.03
_BOARD_GAP = 0.45
_CIRCLE_POINTS = 48
_GLASS_COLOR = (0.62, 0.82, 0.88)


@dataclass(frozen=True)
class Solid:
    """An upright box or cylinder, or a ball.

    Attributes:
        name: For errors and pictures.
        pose: Middle of its footprint in the world; a box's sides lie along x and y of it.
        size: Full extents (x, y, z), m; a cylinder has twice its radius as x and y.
        bottom: Height of its lower face, m.
        is_round: True for a cylinder and a ball.
        color: RGB, 0..1.
        mass: kg; 0 = fixed.
        glass: Its material if it is a pane, which lies along its x axis; None = opaque.
        texture: Pattern that cameras see on it; "" for none.
        is_ball: True for a ball.
        surface: What it is made of, a name of `surfaces.SURFACES`.
    """

    name: str
    pose: SE2
    size: tuple[float, float, float]
    bottom: float
    is_round: bool
    color: Color
    mass: float = 0.0
    glass: Glass | None = None
    texture: str = ""
    is_ball: bool = False
    surface: str = "smooth"

    def is_at_height(self, height: float) -> bool:
        """Tell whether a horizontal plane at this height (m) cuts the solid."""
        return self.bottom <= height <= self.bottom + self.size[2]

    def signed_distance(self, points_world: np.ndarray) -> np.ndarray:
        """Return the distance of points (N, 2) to the footprint's edge, m; inside negative."""
        local = self.pose.inverse() @ points_world
        if self.is_round:
            return np.hypot(local[:, 0], local[:, 1]) - self.size[0] / 2.0
        beyond = np.abs(local) - np.array(self.size[:2]) / 2.0
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))

    def outline(self) -> np.ndarray:
        """Return the corners of the footprint in the world, counter-clockwise, (N, 2), m."""
        if self.is_round:
            angles = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_POINTS, endpoint=False)
            corners = self.size[0] / 2.0 * np.column_stack((np.cos(angles), np.sin(angles)))
        else:
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(self.size[:2]) / 2
        return self.pose @ corners


def solids_of(world: World) -> list[Solid]:
    """Return every solid of a world, walls first, in the order of the file."""
    solids = [piece for wall in world.walls for piece in _wall_pieces(wall)]
    for box in world.boxes:
        if box.glass is not None:
            solids += _glass_case(box, box.glass)
            continue
        solids += _parts(box, [(0.0, 0.0, 0.0, box.size_m)], mass=box.mass_kg)
    for table in world.tables:
        solids += _parts(table, _table_parts(table.size_m))
    for shelf in world.shelves:
        solids += _parts(shelf, _shelf_parts(shelf.size_m), "rough")
    for column in world.columns:
        size = (2 * column.radius_m, 2 * column.radius_m, column.height_m)
        pose = SE2(*column.center_m, 0.0)
        solid = Solid(column.name, pose, size, 0.0, True, column.color, column.mass_kg)
        made_of = surface_of(column.surface, column.texture)
        solids.append(replace(solid, texture=column.texture, surface=made_of))
    for ball in world.balls:
        size = (2 * ball.radius_m,) * 3
        pose = SE2(*ball.center_m, 0.0)
        solid = Solid(ball.name, pose, size, 0.0, True, ball.color, ball.mass_kg, is_ball=True)
        solids.append(solid)
    return solids


def moved(solids: list[Solid], T_new_old: SE2) -> list[Solid]:
    """Return the solids as seen after moving the whole world by a motion."""
    return [replace(solid, pose=T_new_old @ solid.pose) for solid in solids]


def distance_to_surface(solids: list[Solid], points_world: np.ndarray) -> np.ndarray:
    """Return the distance of each point (N, 2) to the nearest footprint edge, shape (N,), m."""
    if not solids:
        return np.full(len(points_world), np.inf)
    return np.min([np.abs(solid.signed_distance(points_world)) for solid in solids], axis=0)


def _wall_pieces(wall: Wall) -> list[Solid]:
    (x0, y0), (x1, y1) = wall.from_m, wall.to_m
    T_world_wall = SE2(x0, y0, math.atan2(y1 - y0, x1 - x0))
    # Half a thickness longer at both ends, so that walls meet in closed corners.
    beyond = wall.thickness_m / 2.0 if wall.glass is None else 0.0
    cuts, pieces = [-beyond], []
    for door in sorted(wall.doors, key=lambda door: door.at_m):
        cuts += [door.at_m - door.width_m / 2.0, door.at_m + door.width_m / 2.0]
        if door.glass is not None:
            pieces += _glazed(T_world_wall, cuts[-2:], wall.height_m, door.glass, door.frame)
    cuts.append(wall.length + beyond)
    if wall.glass is not None:
        for span in zip(cuts[::2], cuts[1::2], strict=True):
            pieces += _glazed(T_world_wall, list(span), wall.height_m, wall.glass, wall.frame)
        return pieces
    for start, end in zip(cuts[::2], cuts[1::2], strict=True):
        if end - start > 1e-9:
            pose = T_world_wall @ SE2((start + end) / 2.0, 0.0, 0.0)
            size = (end - start, wall.thickness_m, wall.height_m)
            solid = Solid("wall", pose, size, 0.0, False, wall.color, texture=wall.texture)
            pieces.append(replace(solid, surface=surface_of(wall.surface, wall.texture)))
    return pieces


def _glazed(
    T_world_wall: SE2, span: list[float], height: float, glass: Glass, frame: Frame | None
) -> list[Solid]:
    """Return posts, rails and panes that fill a wall from span[0] to span[1] along its line."""
    start, end = span
    if end - start < 1e-9:
        return []
    frame_width, rail = (0.0, 0.0) if frame is None else (frame.width_m, frame.rail_m)
    solids, posts = [], np.array([start, end])
    if frame is not None:
        step = frame.spacing_m or end - start
        posts = np.append(np.arange(start, end - 1e-6 - frame.width_m, step), end)
        parts = [(x, frame.width_m, 0.0, height) for x in posts]
        low_and_high = (0.0, height - rail) if rail else ()
        parts += [((start + end) / 2.0, end - start, z, rail) for z in low_and_high]
        for x, length, bottom, tall in parts:
            pose, size = T_world_wall @ SE2(float(x), 0.0, 0.0), (length, frame.depth_m, tall)
            solids.append(Solid("frame", pose, size, bottom, False, frame.color))
    for left, right in zip(posts[:-1], posts[1:], strict=True):
        pose = T_world_wall @ SE2(float(left + right) / 2.0, 0.0, 0.0)
        size = (float(right - left) - frame_width, glass.thickness_m, height - 2.0 * rail)
        solids.append(Solid("glass", pose, size, rail, False, _GLASS_COLOR, glass=glass))
    return solids


def _glass_case(box: Furniture, glass: Glass) -> list[Solid]:
    """Return the four panes of a box of glass; it has no top, which no planar sensor would see."""
    T_world_box = SE2(*box.center_m, math.radians(box.yaw_deg))
    length, width, height = box.size_m
    x, y = (length - glass.thickness_m) / 2.0, (width - glass.thickness_m) / 2.0
    quarter = math.pi / 2.0
    sides = [(SE2(0.0, s * y, 0.0), length) for s in (-1.0, 1.0)]
    sides += [(SE2(s * x, 0.0, quarter), width) for s in (-1.0, 1.0)]
    return [
        Solid(box.name, T_world_box @ side, (long, glass.thickness_m, height), 0.0, False,
              _GLASS_COLOR, glass=glass)
        for side, long in sides
    ]  # fmt: skip


_Part = tuple[float, float, float, tuple[float, float, float]]  # x, y, bottom, size


def _parts(
    item: Furniture, parts: list[_Part], usual: str = "smooth", mass: float = 0.0
) -> list[Solid]:
    T_world_item = SE2(*item.center_m, math.radians(item.yaw_deg))
    return [
        Solid(
            item.name,
            T_world_item @ SE2(x, y, 0.0),
            size,
            bottom,
            False,
            item.color,
            mass,
            texture=item.texture,
            surface=surface_of(item.surface, item.texture, usual),
        )
        for x, y, bottom, size in parts
    ]


def _table_parts(size: tuple[float, float, float], leg: float = 0.05) -> list[_Part]:
    length, width, height = size
    x, y = (length - leg) / 2.0, (width - leg) / 2.0
    legs = [(i * x, j * y, 0.0, (leg, leg, height - _BOARD)) for i in (-1, 1) for j in (-1, 1)]
    return [*legs, (0.0, 0.0, height - _BOARD, (length, width, _BOARD))]


def _shelf_parts(size: tuple[float, float, float]) -> list[_Part]:
    depth, width, height = size
    y = (width - _BOARD) / 2.0
    parts = [(0.0, j * y, 0.0, (depth, _BOARD, height)) for j in (-1, 1)]
    parts.append((-(depth - _BOARD) / 2.0, 0.0, 0.0, (_BOARD, width, height)))
    levels = np.arange(0.08, height, _BOARD_GAP)
    return [*parts, *((0.0, 0.0, float(z), (depth, width, _BOARD)) for z in levels)]
