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
from sim_bridge.cameras import mirror_rays
from sim_bridge.image_effects import ImageSensor
from sim_bridge.scene import Scene
from sim_bridge.shape_kinds import BOX
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import Furniture, load_world

CUBE_M = 0.13
MAX_CUBES = 40
NEAREST_CUBE_M, FARTHEST_CUBE_M = 0.25, 1.5
NUM_BEARINGS = 720
_COLORS = (
    (0.60, 0.45, 0.30), (0.20, 0.20, 0.24), (0.95, 0.95, 0.93), (0.75, 0.12, 0.10),
    (0.10, 0.25, 0.85), (0.95, 0.80, 0.05), (0.55, 0.55, 0.55), (0.95, 0.45, 0.05),
)  # fmt: skip
_AWAY = 100.0


@dataclass(frozen=True)
class Cube:
    """A cube on the field."""

    pose: SE2
    color: tuple[float, float, float]


class _Boxes:
    """What the renderer draws: the walls, and as many cubes as there are just now."""

    def __init__(self, solids: list[Solid]) -> None:
        spare = Solid("cube", SE2(_AWAY, _AWAY, 0.0), (CUBE_M,) * 3, 0.0, False, (0, 0, 0))
        solids = [*solids, *[spare] * MAX_CUBES]
        self._first = len(solids) - MAX_CUBES
        self.kinds = np.full(len(solids), BOX, dtype=np.int64)
        self.halves = np.array([s.size for s in solids]) / 2.0
        self.colors = np.array([s.color for s in solids], dtype=float)
        self.is_glass = np.zeros(len(solids), dtype=bool)
        self.textures = [s.texture for s in solids]
        self._T = np.stack([_pose3(s.pose, s.bottom + s.size[2] / 2.0) for s in solids])

    def put(self, cubes: tuple[Cube, ...]) -> None:
        """Take other cubes."""
        away = Cube(SE2(_AWAY, _AWAY, 0.0), (0.0, 0.0, 0.0))
        for k, cube in enumerate([*cubes, *[away] * (MAX_CUBES - len(cubes))]):
            self._T[self._first + k] = _pose3(cube.pose, CUBE_M / 2.0)
            self.colors[self._first + k] = cube.color

    def poses(self) -> np.ndarray:
        """Return where each box is, (N, 4, 4)."""
        return self._T


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
        self._boxes = _Boxes(solids_of(world))
        self._scene = Scene(world, self._boxes, np.eye(4))  # type: ignore[arg-type]
        self._rays = mirror_rays(mirror, config.samples, config.refine_above)
        v, u = np.mgrid[: size[1], : size[0]]
        radius = np.hypot(u - mirror.center_u_px, v - mirror.center_v_px)
        gain = np.clip(mirror.max_radius_px - radius + 0.5, 0.0, 1.0)
        edge = np.minimum(radius / mirror.max_radius_px, 1.0)
        self._sensor = ImageSensor(config.image, gain, edge, (seed, *size))
        self.see_through(self.camera)

    def see_through(self, camera: FloorCamera) -> None:
        """Give the floor's detector a camera as it was calibrated; its color is learned anew."""
        keeps = FloorDetectorConfig(color=ColorConfig(adapt_s=0.0, relearn_s=0.0))
        self._detector = FloorDetector(camera, keeps)
        self.mask(self.picture(SE2(-0.35, -0.1, 0.0), (), 0))

    def picture(self, pose: SE2, cubes: tuple[Cube, ...], frame: int) -> np.ndarray:
        """Return what the camera sees from a pose of the robot, (H, W, 3), RGB, uint8."""
        self._boxes.put(cubes)
        T = _pose3(pose, self.camera.height_m)
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


def _pose3(pose: SE2, up: float) -> np.ndarray:
    T = np.eye(4)
    T[:2, :2], T[:3, 3] = _turn(pose.yaw), (pose.x, pose.y, up)
    return T
