"""All pictures of a simulation: what its robots' cameras see, and the world from above."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.observations import StereoImages
from sim_bridge.physics import Physics
from sim_bridge.ranging import is_due
from sim_bridge.robot_model import RobotModel
from sim_bridge.solids import Solid
from sim_bridge.world import World

if TYPE_CHECKING:
    from sim_bridge.cameras import Cameras
    from sim_bridge.scene import Scene

OMNI = "omni"
IsWatched = Callable[[str, str], bool]

_FOV_RAD = math.radians(50.0)


def always(robot: str, camera: str) -> bool:
    """Tell that somebody watches."""
    return True


class Views:
    """Cameras of all robots, and one from above.

    Worlds without cameras do without the compiled renderer, which takes a second to load. Cameras
    are asked for by (robot, `OMNI` or name of a stereo pair).

    Args:
        world: Floor, lamp, ceiling.
        physics: What is where.
        models: Of the robots, by name.
        T_new_old: How the whole world was moved.
        step_ns: Length of a simulation step.
        num_threads: Threads that draw.
    """

    def __init__(
        self,
        world: World,
        physics: Physics,
        models: Mapping[str, RobotModel],
        T_new_old: SE2,
        step_ns: int,
        num_threads: int = 1,
    ) -> None:
        self._world, self._physics, self._models = world, physics, models
        self._T, self._step_ns, self._num_threads = T_new_old, step_ns, num_threads
        self._made: Scene | None = None
        self._cameras: dict[str, Cameras] = {}
        self._seed: int | None = None

    def reset(self, seed: int) -> None:
        """Take the noise of a seed. An image depends on it, what is seen and when, on no other."""
        seeing = {n: m for n, m in self._models.items() if m.config.omni or m.config.stereo}
        if seeing and seed != self._seed:
            from sim_bridge.cameras import Cameras

            scene = self._scene()
            self._cameras = {n: Cameras(n, m, scene, seed) for n, m in seeing.items()}
        self._seed = seed

    def omni(self, name: str, stamp_ns: int, is_watched: IsWatched = always) -> np.ndarray | None:
        """Return a robot's mirror image, RGB uint8, if one is due and watched."""
        config = self._models[name].config.omni
        if config is None or not is_due(stamp_ns, config.period_s, self._step_ns):
            return None
        if not is_watched(name, OMNI):
            return None
        return self._cameras[name].omni(self._physics, self._frame(stamp_ns, config.period_s))

    def stereo(
        self, name: str, stamp_ns: int, is_watched: IsWatched = always
    ) -> Mapping[str, StereoImages] | None:
        """Return a robot's stereo images by watched pair, if they are due and there are any."""
        config = self._models[name].config.stereo
        if config is None or not is_due(stamp_ns, config.period_s, self._step_ns):
            return None
        pairs = [pair for pair in config.pairs if is_watched(name, pair)]
        frame, cameras = self._frame(stamp_ns, config.period_s), self._cameras[name]
        return {pair: cameras.stereo(pair, self._physics, frame) for pair in pairs} or None

    def _frame(self, stamp_ns: int, period_s: float) -> int:
        return stamp_ns // max(round(period_s * 1e9), self._step_ns)

    def overview(self, solids: list[Solid], size: tuple[int, int]) -> np.ndarray:
        """Return a picture of the world from above, (height, width, 3), RGB uint8."""
        corners = np.vstack([solid.outline() for solid in solids] or [np.zeros((1, 2))])
        floor = self._world.floor
        if floor.from_m != floor.to_m:  # the painted part is what the world is about
            corners = self._T @ np.array([floor.from_m, floor.to_m])
        low, high = corners.min(axis=0), corners.max(axis=0)
        middle = (low + high) / 2.0
        extent = float(max((high - low)[1], (high - low)[0] * 0.75, 1.0))
        target = (float(middle[0]), float(middle[1]) + 0.03 * extent, 0.0)
        eye = (float(middle[0]), float(middle[1]) - 0.35 * extent, 1.45 * extent)
        if floor.from_m == floor.to_m:
            return self._physics.picture(eye, target, size, has_glass=True)
        return self.picture(eye, target, size)

    def picture(
        self,
        eye: tuple[float, float, float],
        target: tuple[float, float, float],
        size: tuple[int, int],
        up: tuple[float, float, float] = (0.0, 1.0, 0.0),
        fov_rad: float = _FOV_RAD,
    ) -> np.ndarray:
        """Return what a camera at a point sees of everything, textures too, RGB uint8.

        `fov_rad` is the angle from the image's upper edge to its lower one.
        """
        from sim_bridge.cameras import pinhole_rays

        focal_px = size[1] / 2.0 / math.tan(fov_rad / 2.0)
        rays = pinhole_rays(*size, focal_px, samples=2)
        light = self._scene().light_at(rays, looking(eye, target, up), has_ceiling=False)
        return np.clip(np.rint(255.0 * light), 0, 255).astype(np.uint8)

    def _scene(self) -> Scene:
        if self._made is None:
            from sim_bridge.scene import Scene

            T = np.eye(4)
            c, s = math.cos(self._T.yaw), math.sin(self._T.yaw)
            T[:2, :2], T[:2, 3] = [[c, -s], [s, c]], [self._T.x, self._T.y]
            self._made = Scene(self._world, self._physics.drawn_shapes(), T, self._num_threads)
        return self._made


def looking(
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
    up: tuple[float, float, float],
) -> np.ndarray:
    """Return the pose of a camera: x right, y down, z along the view; `up` is up in its image."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, :3] = np.column_stack((right, np.cross(forward, right), forward))
    T[:3, 3] = eye
    return T
