"""A world as cameras see it: shapes, textures, floor, lamp."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from sim_bridge.camera_rays import Rays
from sim_bridge.floor_picture import floor_picture
from sim_bridge.ray_shapes import COLOR, HALF, NUM_COLUMNS
from sim_bridge.rendering import render
from sim_bridge.shading import Ground, Lighting, Shapes
from sim_bridge.still_shapes import Drawable
from sim_bridge.textures import PATTERN_TEXEL, atlas_of, pattern
from sim_bridge.world import World

CEILING_COLOR = (0.85, 0.85, 0.83)


class Scene:
    """Everything that is in a picture, for any number of cameras.

    Args:
        world: Floor, lamp and ceiling.
        drawn: The shapes.
        T_new_old: How the whole world was moved, (4, 4): floor and lamp move with it.
        num_threads: Threads that draw.
    """

    def __init__(
        self, world: World, drawn: Drawable, T_new_old: np.ndarray, num_threads: int = 1
    ) -> None:
        self._drawn, self._T_old_new = drawn, np.linalg.inv(T_new_old)
        names = sorted({name for name in drawn.textures if name})
        pictures, sizes = [pattern(name) for name in names], [PATTERN_TEXEL] * len(names)
        self._textures = np.array([names.index(n) if n else -1 for n in drawn.textures], np.int64)
        floor = floor_picture(world.floor)
        self._ground = Ground(
            floor_texture=-1 if floor is None else len(names),
            floor_low=world.floor.from_m,
            floor_color=world.floor.color,
            ceiling=math.inf if world.ceiling_m is None else world.ceiling_m,
            ceiling_color=CEILING_COLOR,
            sky_color=(0.55, 0.56, 0.58),
        )
        if floor is not None:
            pictures, sizes = [*pictures, floor], [*sizes, world.floor.texel_m]
        self._atlas = atlas_of(pictures, sizes)
        self._lighting = _lighting(world)
        self._num_threads = num_threads
        self._pool = ThreadPoolExecutor(num_threads, "draw") if num_threads > 1 else None

    def light_at(
        self, rays: Rays, T_world_camera: np.ndarray, *, has_ceiling: bool = True
    ) -> np.ndarray:
        """Return the light that reaches a camera now, (height, width, 3) float32, RGB."""
        ground = self._ground
        if not has_ceiling:
            ground = ground._replace(ceiling=math.inf)
        return render(
            rays, self._T_old_new @ T_world_camera, self._around(T_world_camera), ground,
            self._lighting, self._atlas, self._pool, self._num_threads,
        )  # fmt: skip

    def _around(self, T_world_camera: np.ndarray) -> Shapes:
        T_camera_shape = np.linalg.inv(T_world_camera) @ self._drawn.poses()
        turns = T_camera_shape[:, :3, :3].transpose(0, 2, 1)
        places = np.empty((len(turns), NUM_COLUMNS))
        places[:, :9] = turns.reshape(-1, 9)
        places[:, 9:HALF] = -np.einsum("nij,nj->ni", turns, T_camera_shape[:, :3, 3])
        places[:, HALF:COLOR], places[:, COLOR:] = self._drawn.halves, self._drawn.colors
        return Shapes(places, self._drawn.kinds, self._textures, self._drawn.is_glass)


def _lighting(world: World) -> Lighting:
    x, y, z = world.light.direction
    length = math.hypot(x, y, z)
    # A floor in full light shows its own color.
    full = world.light.ambient + (1.0 - world.light.ambient) * z / length
    red, green, blue = world.light.color
    return Lighting(
        direction=(x / length, y / length, z / length),
        color=(red / full, green / full, blue / full),
        ambient=world.light.ambient,
        shadow=world.light.shadow,
    )
