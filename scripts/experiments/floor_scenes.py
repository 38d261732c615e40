"""Seeded scenes on the small-size field, their pictures, and the truth about free space.

A world is the field with two to six 130 mm cubes of any color but the floor's, a ball, and five
robots; each robot's picture is one scene. Lamp, its color, shadows and exposure are drawn anew for
each world. The floor's color is learned once a world, by its first robot, which has free floor
around it; the others have it from there and may stand anywhere, 1 cm from a cube or in a corner. In
every other world the light then changes to another one. The truth comes from the geometry alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.appearance import Light
from sim_bridge.simulation import Simulation
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import Furniture, RobotPlacement, World, load_world

ROBOTS_PER_WORLD = 5
CUBE_M = 0.13
ROBOT_RADIUS_M = 0.085
_MAX_CUBES = 6
_GAP_M = 0.01
_FREE_M = 0.35  # around the first robot
_COLORS = (
    (0.60, 0.45, 0.30), (0.20, 0.20, 0.24), (0.95, 0.95, 0.93), (0.75, 0.12, 0.10),
    (0.10, 0.25, 0.85), (0.95, 0.80, 0.05), (0.55, 0.55, 0.55), (0.95, 0.45, 0.05),
)  # fmt: skip
_HALF_X, _HALF_Y = 1.37, 0.7625
_RAYS_PER_DIRECTION = 9


@dataclass(frozen=True)
class Scene:
    """What one robot sees, and where.

    Attributes:
        pose: `T_world_base`, the camera above its origin.
        solids: All that stands on the floor but this robot; other robots as cylinders.
        learned_from: Picture in which the floor's color is learned, RGB.
        before: What this robot saw in the first light, RGB; None if the light has not changed.
        picture: Picture to judge, RGB.
    """

    pose: SE2
    solids: tuple[Solid, ...]
    learned_from: np.ndarray
    before: np.ndarray | None
    picture: np.ndarray


@dataclass(frozen=True)
class CubeView:
    """A cube of whose central half nothing nearer hides a part.

    Attributes:
        near: Distance of its nearest point, m.
        bearings: Through its central half, (N,), rad.
        faces: Distance of its near face along them, (N,), m.
    """

    near: float
    bearings: np.ndarray
    faces: np.ndarray


@dataclass(frozen=True)
class Truth:
    """What there is to see in a scene.

    Attributes:
        ranges: Nearest thing within each direction's sector, (J,), m, by J.
        cubes: The cubes that can be seen.
    """

    ranges: dict[int, np.ndarray]
    cubes: tuple[CubeView, ...]


def scenes(size: tuple[int, int], num: int, seed: int) -> Iterator[Scene]:
    """Yield scenes at an image size; the same seed gives the same worlds at every size."""
    for k in range(-(-num // ROBOTS_PER_WORLD)):
        rng = np.random.default_rng([seed, k])
        first = _in_light(_world(size, rng), rng)
        second = _in_light(first, rng) if k % 2 else None
        before = _pictures(first, seed + k)
        after = before if second is None else _pictures(second, seed + k)
        solids = _solids(first)
        for robot in first.robots[: num - k * ROBOTS_PER_WORLD]:
            yield Scene(
                robot.pose,
                tuple(s for s in solids if s.name != robot.name),
                before[first.robots[0].name],
                None if second is None else before[robot.name],
                after[robot.name],
            )


def true_ranges(scene: Scene, num_directions: int) -> np.ndarray:
    """Return the nearest thing within each direction's sector, (J,), m."""
    J, n = num_directions, _RAYS_PER_DIRECTION
    offsets = (np.arange(n) / (n - 1) - 0.5) * (2.0 * math.pi / J)
    bearings = -math.pi + 2.0 * math.pi / J * np.arange(J)[:, None] + offsets
    return cast(scene, bearings.ravel(), scene.solids).reshape(J, n).min(axis=1)


def cast(scene: Scene, bearings: np.ndarray, solids: tuple[Solid, ...]) -> np.ndarray:
    """Return the distance to the first footprint along bearings (N,) of the robot, (N,), m."""
    nearest = np.full(len(bearings), np.inf)
    for solid in solids:
        own = solid.pose.inverse() @ scene.pose
        angles = bearings + own.yaw
        ways = np.stack((np.cos(angles), np.sin(angles)), -1)
        start = np.array([own.x, own.y])
        hit = _disk if solid.is_round else _box
        nearest = np.minimum(nearest, hit(start, ways, np.array(solid.size[:2]) / 2.0))
    return nearest


def truth_of(scene: Scene, numbers_of_directions: set[int]) -> Truth:
    """Return the truth for templates of some numbers of directions."""
    views = (_cube_view(scene, solid) for solid in scene.solids if solid.name == "cube")
    return Truth(
        {J: true_ranges(scene, J) for J in numbers_of_directions},
        tuple(view for view in views if view is not None),
    )


def _cube_view(scene: Scene, cube: Solid) -> CubeView | None:
    to = scene.pose.inverse() @ np.array([[cube.pose.x, cube.pose.y]])
    width = 4.0 * math.atan(CUBE_M / np.hypot(*to[0]))
    rays = math.atan2(to[0, 1], to[0, 0]) + np.linspace(-0.5, 0.5, 361) * width
    own = cast(scene, rays, (cube,))
    (hit,) = np.nonzero(np.isfinite(own))
    quarter = (hit[-1] - hit[0]) // 4
    half = slice(hit[0] + quarter, hit[-1] - quarter + 1)
    others = tuple(solid for solid in scene.solids if solid is not cube)
    if (cast(scene, rays[half], others) < own[half]).any():
        return None
    return CubeView(float(own[hit].min()), rays[half], own[half])


def _box(start: np.ndarray, ways: np.ndarray, half: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (-half - start) / ways, (half - start) / ways
    enter = np.minimum(low, high).max(axis=1)
    leave = np.maximum(low, high).min(axis=1)
    return np.where((enter <= leave) & (enter > 0.0), enter, np.inf)


def _disk(start: np.ndarray, ways: np.ndarray, half: np.ndarray) -> np.ndarray:
    along = -ways @ start
    inside = half[0] ** 2 - (start @ start - along**2)
    enter = along - np.sqrt(np.maximum(inside, 0.0))
    return np.where((inside >= 0.0) & (enter > 0.0), enter, np.inf)


def _world(size: tuple[int, int], rng: np.random.Generator) -> World:
    """Return the field with cubes, ball and robots at free places."""
    field = load_world("small_size_field")
    taken: list[tuple[np.ndarray, float]] = []
    robots = []
    for k in range(ROBOTS_PER_WORLD):
        x, y = _place(ROBOT_RADIUS_M if k else _FREE_M, taken, rng)
        yaw = float(rng.uniform(-180.0, 180.0))
        omni = {"width_px": size[0], "height_px": size[1]}
        robots.append(
            RobotPlacement(
                model="soccer_small_size", name=f"r{k}", position_m=(x, y), yaw_deg=yaw,
                overrides={"omni": omni},
            )
        )  # fmt: skip
    boxes = [box for box in field.boxes if box.name != "cube"]
    for _ in range(int(rng.integers(2, _MAX_CUBES + 1))):
        center = _place(CUBE_M / math.sqrt(2.0), taken, rng)
        color = _COLORS[int(rng.integers(len(_COLORS)))]
        yaw = float(rng.uniform(0.0, 90.0))
        boxes.append(Furniture(
            name="cube", center_m=center, size_m=(CUBE_M,) * 3, yaw_deg=yaw, color=color
        ))  # fmt: skip
    ball = replace(field.balls[0], center_m=_place(0.0215, taken, rng))
    return replace(field, boxes=tuple(boxes), balls=(ball,), robots=tuple(robots))


def _place(
    radius: float, taken: list[tuple[np.ndarray, float]], rng: np.random.Generator
) -> tuple[float, float]:
    """Return a place where a disk touches nothing, and take it."""
    reach = np.array([_HALF_X, _HALF_Y]) - radius - _GAP_M
    while True:
        place = rng.uniform(-reach, reach)
        if all(np.hypot(*(place - other)) > radius + r + _GAP_M for other, r in taken):
            taken.append((place, radius))
            return float(place[0]), float(place[1])


def _in_light(world: World, rng: np.random.Generator) -> World:
    """Return the world under another lamp, seen at another exposure."""
    turn, height = rng.uniform(-math.pi, math.pi), rng.uniform(0.8, 3.0)
    warm, cold = np.array((1.0, 0.86, 0.68)), np.array((0.86, 0.94, 1.0))
    tint = 1.0 + rng.uniform() * ((warm if rng.uniform() < 0.5 else cold) - 1.0)
    light = Light(
        direction=(math.cos(turn), math.sin(turn), height),
        color=tuple(float(c) for c in tint),
        ambient=float(rng.uniform(0.4, 0.7)),
        shadow=float(rng.uniform(0.4, 0.8)),
    )
    image = {"exposure": float(rng.uniform(0.6, 1.3))}
    robots = tuple(
        replace(r, overrides={"omni": {**r.overrides["omni"], "image": image}})
        for r in world.robots
    )
    return replace(world, light=light, robots=robots)


def _pictures(world: World, seed: int) -> dict[str, np.ndarray]:
    simulation = Simulation(world, seed=seed)
    try:
        while True:
            seen = {n: s.omni for n, s in simulation.step({}).robots.items() if s.omni is not None}
            if seen:
                return seen
    finally:
        simulation.close()


def _solids(world: World) -> list[Solid]:
    size = (2.0 * ROBOT_RADIUS_M, 2.0 * ROBOT_RADIUS_M, 0.2)
    others = [Solid(r.name, r.pose, size, 0.0, True, (0.3, 0.3, 0.3)) for r in world.robots]
    return [*solids_of(world), *others]
