"""Fields of cubes on the small-size field: one as in the paper's Fig. 9, and random ones by seed.

The figure's coordinates are not in the text: ours has two cubes to drive between and one in the way
to the goal behind it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from sim_bridge.solids import solids_of
from sim_bridge.world import Furniture, RobotPlacement, World, load_world

ROBOT_RADIUS = 0.085
CUBE = 0.13
_NUM_CUBES = (4, 9)
_PASSAGE = 0.12  # air on both sides of the robot that a way to the goal has at least
_GRID = 0.02


@dataclass(frozen=True)
class Field:
    """Where things stand.

    Attributes:
        name: For tables.
        start: x, y of the robot, m.
        goal: x, y to reach, m.
        cubes: x, y, yaw (rad) of each cube, shape (N, 3).
    """

    name: str
    start: tuple[float, float]
    goal: tuple[float, float]
    cubes: np.ndarray


def figure_9() -> Field:
    """Return the layout that stands for the paper's Fig. 9."""
    cubes = np.array([[0.50, 0.03, 0.2], [0.05, -0.50, -0.4], [0.10, 0.52, 0.6]])
    return Field("figure 9", (-1.15, 0.0), (1.15, 0.0), cubes)


def random_field(seed: int, number: int) -> Field:
    """Return a field of 4 to 8 cubes with a way through it that is wide enough for the robot."""
    rng = np.random.default_rng([seed, number])
    while True:
        count = int(rng.integers(*_NUM_CUBES))
        xy = rng.uniform((-0.75, -0.62), (0.75, 0.62), (count, 2))
        cubes = np.column_stack((xy, rng.uniform(-math.pi / 4, math.pi / 4, count)))
        start = (float(rng.uniform(-1.15, -1.0)), float(rng.uniform(-0.5, 0.5)))
        goal = (float(rng.uniform(1.0, 1.15)), float(rng.uniform(-0.5, 0.5)))
        field = Field(f"random {number}", start, goal, cubes)
        if _has_way(field):
            return field


def world_of(field: Field, omni: dict[str, object]) -> World:
    """Return the small-size field with the cubes of a field and the robot at its start."""
    world = load_world("small_size_field")
    colors = ((0.60, 0.45, 0.30), (0.20, 0.20, 0.24))
    cubes = tuple(
        Furniture(
            name="cube", center_m=(float(x), float(y)), size_m=(CUBE,) * 3,
            yaw_deg=math.degrees(yaw), color=colors[k % 2],
        )
        for k, (x, y, yaw) in enumerate(field.cubes)
    )  # fmt: skip
    boxes = tuple(box for box in world.boxes if box.name != "cube") + cubes
    robot = RobotPlacement(
        model="soccer_small_size", position_m=field.start, overrides={"omni": omni}
    )
    return replace(world, boxes=boxes, balls=(), robots=(robot,), route=None)


def _has_way(field: Field) -> bool:
    """Tell whether the robot's middle can get from start to goal with some air."""
    x = np.arange(-1.37, 1.37, _GRID)
    y = np.arange(-0.7625, 0.7625, _GRID)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    solids = [s for s in solids_of(world_of(field, {})) if s.bottom < 0.2]
    clear = np.min([s.signed_distance(points) for s in solids], axis=0).reshape(len(y), len(x))
    _, labels = cv2.connectedComponents((clear > ROBOT_RADIUS + _PASSAGE).astype(np.uint8))
    start, goal = (
        labels[round((p[1] - y[0]) / _GRID), round((p[0] - x[0]) / _GRID)]
        for p in (field.start, field.goal)
    )
    return bool(start == goal != 0)
