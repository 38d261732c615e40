"""Stereo pairs rendered in a room from random poses, with the true distance of every pixel.

The room, the robot's cameras and their noise are the simulator's; the distances are computed here,
from the room's solids and not from what was drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.camera_config import optical_frame
from sim_bridge.cameras import Cameras
from sim_bridge.robot_model import load_robot
from sim_bridge.scene import Scene
from sim_bridge.solids import Solid, solids_of
from sim_bridge.still_shapes import StillShapes, solid_pose, upright_pose
from sim_bridge.world import load_world

WORLD = "stereo_room"
CLEARANCE_M, GAP_M = 0.45, 0.03
PAIR = "front"


@dataclass(frozen=True)
class View:
    """What a pair of cameras sees.

    Attributes:
        pose: `T_world_base`.
        left: (H, W, 3), RGB, uint8.
        right: The same.
        depth: True distance along the left camera's axis, (H, W), m.
    """

    pose: SE2
    left: np.ndarray
    right: np.ndarray
    depth: np.ndarray


class _Base:
    """Where the robot stands."""

    def __init__(self) -> None:
        self.T_world_base = np.eye(4)

    def sensor_pose(self, name: str, T_base_sensor: np.ndarray) -> np.ndarray:
        return np.asarray(self.T_world_base @ T_base_sensor)


class StereoRoom:
    """Renders what a robot's pairs of cameras see.

    Args:
        seed: Of the sensors' noise.
        name: The world; its first robot has the cameras.

    Attributes:
        world: The world.
        solids: What stands in it.
        size_px: Columns and rows of each image.
        baseline_m: From the left camera to the right one.
        focal_px: Of both.
        fov_rad: Of both.
        farthest_m: The room's diagonal; nothing is farther.
        T_base_left: Pose of each pair's left camera, by name.
    """

    def __init__(self, seed: int, name: str = WORLD) -> None:
        world = load_world(name)
        model = load_robot(world.robots[0])
        assert model.config.stereo is not None
        model = replace(model, config=replace(model.config, omni=None))
        self.world, self.solids = world, solids_of(world)
        stereo = model.config.stereo
        self.baseline_m, self.focal_px = model.baseline(PAIR), stereo.focal_px
        self.fov_rad = stereo.fov_rad
        self.size_px = stereo.width_px, stereo.height_px
        self.T_base_left = {p: model.mounts[optical_frame(p, "left")] for p in stereo.pairs}
        self._footprint = edge_points(np.array(model.config.footprint_m))
        self._low, self._high = np.array(world.floor.from_m), np.array(world.floor.to_m)
        self.farthest_m = float(np.hypot(*(self._high - self._low)))
        self._base = _Base()
        scene = Scene(world, StillShapes(self.solids), np.eye(4))
        self._cameras = Cameras("", model, scene, seed)

    def views(self, num: int, rng: np.random.Generator) -> Iterator[View]:
        """Yield views from random poses that keep clear of everything."""
        for k in range(num):
            yield self.view(self.random_pose(rng), k)

    def random_pose(self, rng: np.random.Generator) -> SE2:
        """Return a pose of the robot anywhere it has room."""
        while True:
            place = rng.uniform(self._low, self._high)
            gaps = [float(s.signed_distance(place[None])[0]) for s in self.solids]
            if min(gaps) >= CLEARANCE_M:
                return SE2(float(place[0]), float(place[1]), float(rng.uniform(-np.pi, np.pi)))

    def standing_pose(self, rng: np.random.Generator) -> SE2:
        """Return a pose at which the robot's footprint is clear of everything."""
        while True:
            x, y = rng.uniform(self._low, self._high)
            pose = SE2(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))
            if self.gap(pose) >= GAP_M:
                return pose

    def gap(self, pose: SE2) -> float:
        """Return how far the robot's footprint is from what is nearest, m."""
        outline = pose @ self._footprint
        return min(float(s.signed_distance(outline).min()) for s in self.solids)

    def view(self, pose: SE2, frame: int, pair: str = PAIR) -> View:
        """Return what a pair sees from a pose; the noise is that of a frame's number."""
        T = upright_pose(pose, 0.0)
        self._base.T_world_base = T
        images = self._cameras.stereo(pair, self._base, frame)
        return View(pose, images.left, images.right, self._depth(T @ self.T_base_left[pair]))

    def _depth(self, T_world_camera: np.ndarray) -> np.ndarray:
        width, height = self.size_px
        v, u = np.mgrid[:height, :width]
        rays = np.stack(
            ((u - (width - 1) / 2.0) / self.focal_px, (v - (height - 1) / 2.0) / self.focal_px,
             np.ones(u.shape)), axis=-1,
        )  # fmt: skip
        turned = rays.reshape(-1, 3) @ T_world_camera[:3, :3].T
        ceiling = math.inf if self.world.ceiling_m is None else self.world.ceiling_m
        depth = room_depth(T_world_camera[:3, 3], turned, self.solids, ceiling)
        return depth.reshape(height, width)


def edge_points(corners: np.ndarray, spacing: float = 0.05) -> np.ndarray:
    """Return points along the edges between corners (N, 2), m."""
    parts = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        num = max(math.ceil(float(np.linalg.norm(end - start)) / spacing), 1)
        parts.append(start + np.arange(num)[:, None] / num * (end - start))
    return np.vstack(parts)


def room_depth(
    origin: np.ndarray, rays: np.ndarray, solids: list[Solid], ceiling: float
) -> np.ndarray:
    """Return how many times each ray fits between its origin and what it meets first, (N,).

    Args:
        origin: In the world, (3,).
        rays: (N, 3), of any length: with one of 1 along the view it is the depth.
        solids: Upright boxes and cylinders.
        ceiling: Its height, m; the floor is at 0.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[:, 2] < 0.0, -origin[2] / rays[:, 2], np.inf)
        depth = np.where(rays[:, 2] > 0.0, (ceiling - origin[2]) / rays[:, 2], depth)
        for solid in solids:
            T = solid_pose(solid)
            start, way = (origin - T[:3, 3]) @ T[:3, :3], rays @ T[:3, :3]
            half = np.array(solid.size) / 2.0
            near, far = _slabs(start[2:], way[:, 2:], half[2:])
            sides = _disc if solid.is_round else _slabs
            enter, leave = sides(start[:2], way[:, :2], half[:2])
            near, far = np.maximum(near, enter), np.minimum(far, leave)
            depth = np.where((near <= far) & (near > 0.0), np.minimum(depth, near), depth)
    return depth


def _slabs(start: np.ndarray, way: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    one, other = (-half - start) / way, (half - start) / way
    return np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)


def _disc(start: np.ndarray, way: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a = (way**2).sum(axis=1)
    b = way @ start
    c = float(start @ start) - half[0] ** 2
    root = np.sqrt(b**2 - a * c)
    near, far = (-b - root) / a, (-b + root) / a
    return np.where(np.isnan(near), np.inf, near), np.where(np.isnan(far), -np.inf, far)
