"""Masks of a floor without a renderer: a pixel is floor if its middle sees the floor."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_plan import FloorPlan

BLIND_M = 0.17


def small_camera(width: int = 256, height: int = 220) -> FloorCamera:
    mirror = paper_camera().resized(width, height)
    return FloorCamera(mirror, mirror.viewpoint_height)


def rectangle(length: float, width: float) -> FloorPlan:
    x, y = length / 2.0, width / 2.0
    return FloorPlan(np.array([[x, -y], [x, y], [-x, y], [-x, -y]]))


def ell() -> FloorPlan:
    """A rectilinear room that no turn brings onto itself."""
    return FloorPlan(
        np.array([[-1.2, -1.0], [1.4, -1.0], [1.4, 0.2], [0.3, 0.2], [0.3, 1.1], [-1.2, 1.1]])
    )


def alcoves() -> FloorPlan:
    """A corridor of 8 m with seven like alcoves, their distances from its two ends unlike."""
    corners = [(0.0, 0.0), (8.0, 0.0), (8.0, 1.2)]
    for k in range(7, 0, -1):
        corners += [(k + 0.6, 1.2), (k + 0.6, 1.8), (k + 0.1, 1.8), (k + 0.1, 1.2)]
    return FloorPlan(np.array([*corners, (0.0, 1.2)]))


def mask_of(
    camera: FloorCamera,
    plan: FloorPlan,
    pose: SE2,
    posts: tuple[tuple[float, float, float], ...] = (),
) -> np.ndarray:
    """Return the mask that a camera at a pose over the plan has.

    Args:
        camera: The camera.
        plan: The floor; its walls hide all behind them.
        pose: Of the camera, its middle on the plan.
        posts: x, y and radius of posts of any height.
    """
    v, u = np.mgrid[: camera.height_px, : camera.width_px]
    points = camera.floor_points(np.stack((u, v), -1).astype(float)).reshape(-1, 2)
    r = np.hypot(points[:, 0], points[:, 1])
    is_floor = np.isfinite(r)
    is_floor &= np.where(is_floor, r, 0.0) > BLIND_M
    index = np.flatnonzero(is_floor)
    ways = (points[index] / r[index, None]) @ _turn(pose.yaw).T
    ends = first_wall(np.array([pose.x, pose.y]), ways, plan)
    for x, y, radius in posts:
        ends = np.minimum(ends, _post(np.array([x - pose.x, y - pose.y]), radius, ways))
    mask = np.zeros(len(r), np.uint8)
    mask[index[r[index] < ends]] = 255
    return mask.reshape(camera.height_px, camera.width_px)


def first_wall(place: np.ndarray, ways: np.ndarray, plan: FloorPlan) -> np.ndarray:
    """Return the distance of the first edge that rays (N, 2) from a place cross, (N,)."""
    first = np.full(len(ways), np.inf)
    ends = np.roll(plan.corners, -1, axis=0)
    for a, b in zip(plan.corners - place, ends - place, strict=True):
        edge = b - a
        det = ways[:, 0] * -edge[1] + ways[:, 1] * edge[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            r = (a[0] * -edge[1] + a[1] * edge[0]) / det
            share = (ways[:, 0] * a[1] - ways[:, 1] * a[0]) / det
        hit = (r > 0.0) & (share >= 0.0) & (share <= 1.0)
        first = np.where(hit, np.minimum(first, r), first)
    return first


def _post(middle: np.ndarray, radius: float, ways: np.ndarray) -> np.ndarray:
    along = ways @ middle
    apart = np.abs(ways[:, 0] * middle[1] - ways[:, 1] * middle[0])
    hit = (along > 0.0) & (apart < radius)
    return np.where(hit, along - np.sqrt(np.maximum(radius**2 - apart**2, 0.0)), np.inf)


def _turn(yaw: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])
