"""Pictures of the small-size field as a mirror sees it, from anywhere, with cubes anywhere.

The scene, its floor picture and the camera's rays are made once a light, so that a picture costs
its rays alone. What stands on the field is the world's walls and goals and cubes of 130 mm, with
colors drawn at random; the robot itself is left out, the mask does not reach so near.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from floor_perception.config import ColorConfig, FloorDetectorConfig
from floor_perception.floor_detector import FloorDetector
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_plan import FloorPlan
from sim_bridge.appearance import Light
from sim_bridge.camera_config import ImageConfig, OmniCameraConfig
from sim_bridge.cameras import mirror_rays, mirror_sensor
from sim_bridge.scene import Scene
from sim_bridge.solids import Solid, solids_of
from sim_bridge.still_shapes import StillShapes, upright_pose
from sim_bridge.world import Furniture, load_world

CUBE_M = 0.13
MAX_CUBES = 40
NEAREST_CUBE_M, FARTHEST_CUBE_M = 0.25, 1.5
NUM_BEARINGS = 720
_COLORS = (
    (0.60, 0.45, 0.30), (0.20, 0.20, 0.24), (0.95, 0.95, 0.93), (0.75, 0.12, 0.10),
    (0.10, 0.25, 0.85), (0.95, 0.80, 0.05), (0.55, 0.55, 0.55), (0.95, 0.45, 0.05),
)  # fmt: skip
_AWAY = SE2(100.0, 100.0, 0.0)


@dataclass(frozen=True)
class Cube:
    """A cube on the field."""

    pose: SE2
    color: tuple[float, float, float]


def _with_cubes(solids: list[Solid]) -> StillShapes:
    """Return solids and, far away, as many cubes as there may be."""
    spare = Solid("cube", _AWAY, (CUBE_M,) * 3, 0.0, False, (0, 0, 0))
    return StillShapes([*solids, *[spare] * MAX_CUBES])


class FieldCamera:
    """Takes pictures and masks of the field at one size in one light.

    Args:
        size: Columns and rows.
        light: The lamp; None for the world's own.
        image: Lens and sensor.
        seed: Of the noise.
    """

    def __init__(
        self,
        size: tuple[int, int],
        light: Light | None = None,
        image: ImageConfig | None = None,
        seed: int = 0,
    ) -> None:
        world = load_world("small_size_field")
        world = replace(
            world,
            light=world.light if light is None else light,
            boxes=tuple(b for b in world.boxes if not _is_cube(b)),
            balls=(),
            robots=(),
        )
        config = OmniCameraConfig(width_px=size[0], height_px=size[1], image=image or ImageConfig())
        mirror = config.camera()
        self.camera = FloorCamera(mirror, mirror.viewpoint_height)
        solids = solids_of(world)
        self._first_cube, self._shapes = len(solids), _with_cubes(solids)
        self._scene = Scene(world, self._shapes, np.eye(4))
        self._rays = mirror_rays(mirror, config.samples, config.refine_above)
        self._sensor = mirror_sensor(config, (seed, *size))
        self.see_through(self.camera)

    def see_through(self, camera: FloorCamera) -> None:
        """Give the floor's detector a camera as it was calibrated; its color is learned anew."""
        keeps = FloorDetectorConfig(color=ColorConfig(adapt_s=0.0, relearn_s=0.0))
        self._detector = FloorDetector(camera, keeps)
        self.mask(self.picture(SE2(-0.35, -0.1, 0.0), (), 0))

    def picture(self, pose: SE2, cubes: tuple[Cube, ...], frame: int) -> np.ndarray:
        """Return what the camera sees from a pose of the robot, (H, W, 3), RGB, uint8."""
        away = Cube(_AWAY, (0.0, 0.0, 0.0))
        for k, cube in enumerate([*cubes, *[away] * (MAX_CUBES - len(cubes))]):
            self._shapes.put(self._first_cube + k, cube.pose, cube.color)
        T = upright_pose(pose, self.camera.height_m)
        return self._sensor.expose(self._scene.light_at(self._rays, T), frame)

    def mask(self, picture: np.ndarray) -> np.ndarray:
        """Return the floor mask as floor_detector makes it; its color was learned in the middle."""
        result = self._detector.detect(picture, "rgb", 0)
        if result is None:
            raise ValueError("the floor's color cannot be learned in this light")
        return result.mask


def random_cubes(pose: SE2, num: int, plan: FloorPlan, rng: np.random.Generator) -> list[Cube]:
    """Return cubes anywhere on the field that touch neither each other nor the robot."""
    cubes: list[Cube] = []
    while len(cubes) < num:
        cubes.append(_one_more(pose, cubes, plan, rng))
    return cubes


def scene_hiding(
    share: float, plan: FloorPlan, height: float, rng: np.random.Generator
) -> tuple[SE2, tuple[Cube, ...]]:
    """Return a pose anywhere and cubes that hide a share of the border from it, to 2 % of all."""
    while True:
        x, y, yaw = rng.uniform((-1.17, -0.56, -math.pi), (1.17, 0.56, math.pi)).tolist()
        pose = SE2(x, y, yaw)
        cubes: list[Cube] = []
        hidden = 0.0
        for _ in range(4 * MAX_CUBES):
            if len(cubes) == MAX_CUBES or hidden >= share - 0.02:
                break
            cube = _one_near(pose, cubes, plan, rng)
            more = hidden if cube is None else hidden_share(pose, [*cubes, cube], plan, height)
            if cube is not None and more <= share + 0.02:
                cubes, hidden = [*cubes, cube], more
        if abs(hidden - share) <= 0.02:
            return pose, tuple(cubes)


def hidden_share(pose: SE2, cubes: list[Cube], plan: FloorPlan, height: float) -> float:
    """Return the share of directions in which a cube hides where the floor ends."""
    return float(is_hidden(pose, cubes, plan, height).mean()) if cubes else 0.0


def is_hidden(
    pose: SE2, cubes: list[Cube], plan: FloorPlan, height: float, num: int = NUM_BEARINGS
) -> np.ndarray:
    """Return in which of the directions from 0 on a cube hides the floor's end, (num,), bool."""
    bearings = pose.yaw + 2.0 * math.pi / num * np.arange(num)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    walls = wall_distance(np.array([pose.x, pose.y]), ways, plan)
    hidden = np.zeros(num, dtype=bool)
    for cube in cubes:
        own = cube.pose.inverse()
        start, turned = (own @ np.array([[pose.x, pose.y]]))[0], ways @ _turn(own.yaw).T
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high = (-CUBE_M / 2 - start) / turned, (CUBE_M / 2 - start) / turned
        enter, leave = np.minimum(low, high).max(axis=1), np.maximum(low, high).min(axis=1)
        # The ray to the wall's foot goes down; where it leaves the cube it is lowest.
        lowest = height * (1.0 - np.minimum(leave, walls) / walls)
        hidden |= (enter < leave) & (enter > 0.0) & (enter < walls) & (lowest < CUBE_M)
    return hidden


def wall_distance(place: np.ndarray, ways: np.ndarray, plan: FloorPlan) -> np.ndarray:
    """Return how far the border is from a place on the floor along unit vectors (N, 2), (N,)."""
    gap = plan.offsets - plan.normals @ place
    facing = ways @ plan.normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.where(facing > 0.0, gap / facing, np.inf)
        hits = place + r[..., None] * ways[:, None]
        along = ((hits - plan.corners) * plan.tangents).sum(axis=-1)
        is_hit = (r > 0.0) & (along >= 0.0) & (along <= plan.lengths)
    return np.asarray(np.where(is_hit, r, np.inf).min(axis=1))


def _one_more(pose: SE2, cubes: list[Cube], plan: FloorPlan, rng: np.random.Generator) -> Cube:
    while True:
        x, y = rng.uniform(plan.corners.min(axis=0), plan.corners.max(axis=0))
        if _has_room(x, y, pose, cubes, plan):
            return _cube_at(x, y, rng)


def _one_near(
    pose: SE2, cubes: list[Cube], plan: FloorPlan, rng: np.random.Generator
) -> Cube | None:
    """Return a cube in any direction, as likely near as far; None if it has no room there."""
    r, way = rng.uniform(NEAREST_CUBE_M, FARTHEST_CUBE_M), rng.uniform(-math.pi, math.pi)
    x, y = pose.x + r * math.cos(way), pose.y + r * math.sin(way)
    return _cube_at(x, y, rng) if _has_room(x, y, pose, cubes, plan) else None


def _has_room(x: float, y: float, pose: SE2, cubes: list[Cube], plan: FloorPlan) -> bool:
    radius = CUBE_M / math.sqrt(2.0)
    turns = [k * math.pi / 4.0 for k in range(8)]
    inside = all(plan.contains(x + radius * math.cos(t), y + radius * math.sin(t)) for t in turns)
    far = math.hypot(x - pose.x, y - pose.y) > NEAREST_CUBE_M
    alone = all(math.hypot(x - c.pose.x, y - c.pose.y) > 2.0 * radius for c in cubes)
    return inside and far and alone


def _cube_at(x: float, y: float, rng: np.random.Generator) -> Cube:
    color = _COLORS[int(rng.integers(len(_COLORS)))]
    return Cube(SE2(x, y, float(rng.uniform(0.0, math.pi / 2.0))), color)


def _is_cube(box: Furniture) -> bool:
    return box.name == "cube"


def _turn(yaw: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])
