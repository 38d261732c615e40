"""Border points of known noise, mirrors calibrated from noisy pairs, and the Cramer-Rao bound.

The information that a piece of border with noise of deviation s (independent, the same in both
directions of the image) holds of the pose is g g^T / s^2, g the derivative of its distance from
the border's image, px. A calibration of covariance S adds its parameters as further unknowns with
the information S^-1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from experiments.floor_pose_scenes import CUBE_M, Cube, is_hidden, wall_distance
from floor_perception.mirror_fit import fit_mirror, mirror_radius
from floornav_common.calibration import calibration_of
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_kernels import NUM_VALUES, residuals
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_rays import rays_of_pixels

NUM_PAIRS = 24
PAIR_NOISE_PX = 0.3
CENTER_SD_PX = 0.05
"""Of each coordinate of the mirror's center, as found from its rim in the picture."""
MOST_TRIALS = 20
NEAREST_PAIR_M, FARTHEST_PAIR_M = 0.15, 3.0


@dataclass(frozen=True)
class Mirror:
    """A mirror: gamma_px, xi, height_m and its center's u, v (5,), and their covariance (5, 5)."""

    parameters: np.ndarray
    cov: np.ndarray

    def camera(self, like: FloorCamera) -> FloorCamera:
        """Return a camera with this mirror, else as another one, that says how well it is known."""
        camera = camera_of(self.parameters, like)
        one = np.eye(5)
        keys = {"fx_px": one[0], "fy_px": one[0], "xi": one[1], "height_m": one[2],
                "center_u_px": one[3], "center_v_px": one[4]}  # fmt: skip
        return replace(camera, calibration=calibration_of(keys, self.cov))


def true_mirror(camera: FloorCamera) -> np.ndarray:
    """Return gamma = C / (H A), xi = B f / A, H of a camera of eq. 26, and its center, (5,)."""
    mirror, H = camera.camera, camera.height_m
    A, B, C = mirror.a_px_per_mm, mirror.b_per_mm, mirror.c_px2  # type: ignore[attr-defined]
    return np.array((C / (1000.0 * H * A), B * math.sqrt(C) / A, H, *camera.center_px))


def camera_of(parameters: np.ndarray, like: FloorCamera) -> FloorCamera:
    """Return the camera with a mirror's parameters (5,), else as another one."""
    gamma, xi, H, u, v = (float(p) for p in parameters)
    edge = float(like.camera.max_radius_px)  # type: ignore[attr-defined]
    return FloorCamera(
        UnifiedCamera(
            width_px=like.width_px, height_px=like.height_px, xi=xi, fx_px=gamma, fy_px=gamma,
            center_u_px=u, center_v_px=v, max_radius_px=edge,
        ),
        H,
    )  # fmt: skip


def calibrated(
    camera: FloorCamera, rng: np.random.Generator, noise_px: float = PAIR_NOISE_PX
) -> Mirror:
    """Return the mirror as fitted to measured pairs of pixel radius and distance.

    The pairs lie at distances whose radii are evenly spread; their radii have noise. So has the
    center, CENTER_SD_PX. Pairs that the calibration refuses, because radii fall where distances
    grow, are measured again, as its user would.

    Raises:
        ValueError: If MOST_TRIALS were refused.
    """
    p = true_mirror(camera)
    near, far = (float(mirror_radius(np.array(r), *p[:3]))
                 for r in (NEAREST_PAIR_M, FARTHEST_PAIR_M))  # fmt: skip
    radii = np.linspace(near, far, NUM_PAIRS)
    distances = camera.floor_distance(radii)
    for trial in range(1, MOST_TRIALS + 1):
        try:
            fit = fit_mirror(radii + rng.normal(0.0, noise_px, NUM_PAIRS), distances)
            break
        except ValueError:
            if trial == MOST_TRIALS:
                raise
    center = p[3:] + rng.normal(0.0, CENTER_SD_PX, 2)
    return Mirror(np.append(fit.parameters, center), _with_center(fit.statistics.cov))


def calibration_cov(camera: FloorCamera, noise_px: float = PAIR_NOISE_PX) -> np.ndarray:
    """Return the covariance that such a calibration has, by its noise and the true curve."""
    p = true_mirror(camera)
    near, far = (
        float(mirror_radius(np.array(r), *p[:3])) for r in (NEAREST_PAIR_M, FARTHEST_PAIR_M)
    )
    distances = camera.floor_distance(np.linspace(near, far, NUM_PAIRS))
    J = np.empty((NUM_PAIRS, 3))
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-5 * p[k]
        up, down = (mirror_radius(distances, *(p[:3] + s * step)) for s in (1.0, -1.0))
        J[:, k] = (up - down) / (2.0 * step[k])
    return _with_center(noise_px**2 * np.linalg.inv(J.T @ J))


def _with_center(curve: np.ndarray) -> np.ndarray:
    """Return the covariance of curve and center, (5, 5)."""
    cov = CENTER_SD_PX**2 * np.eye(5)
    cov[:3, :3] = curve
    return cov


def border_pixels(
    camera: FloorCamera, pose: SE2, cubes: tuple[Cube, ...], plan: FloorPlan, num: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the floor ends in the image, (num, 2), and where that is a wall, (num,).

    Where a cube hides the wall the floor ends at the cube's foot.
    """
    bearings = 2.0 * math.pi / num * np.arange(num)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    world = ways @ _turn(pose.yaw).T
    ranges = wall_distance(np.array((pose.x, pose.y)), world, plan)
    hidden = is_hidden(pose, list(cubes), plan, camera.height_m, num)
    for cube in cubes:
        foot = _foot(pose, cube, world)
        ranges = np.where(hidden, np.minimum(ranges, foot), ranges)
    return camera.floor_pixels(ways * ranges[:, None]), ~hidden


def noisy_border(
    camera: FloorCamera, pixels: np.ndarray, sd_px: float, rng: np.random.Generator
) -> np.ndarray:
    """Return pixels (N, 2) with independent noise, those that are not seen left out."""
    seen = pixels[np.isfinite(pixels[:, 0])]
    return np.asarray(seen + rng.normal(0.0, sd_px, seen.shape))


def bound(
    camera: FloorCamera,
    pose: SE2,
    pixels: np.ndarray,
    plan: FloorPlan,
    sd_px: float,
    mirror_cov: np.ndarray | None = None,
) -> np.ndarray:
    """Return the least covariance (3, 3) of x, y, yaw from border at pixels (N, 2).

    Args:
        camera: The true camera.
        pose: The true pose.
        pixels: Border of walls without noise.
        plan: The floor.
        sd_px: Noise of the pixels.
        mirror_cov: Covariance of the calibration, (5, 5); None: the mirror is known.
    """
    p = true_mirror(camera)
    z, G = _distances(camera_of(p, camera), pose, pixels, plan)
    by_mirror = np.zeros((len(z), 5))
    for k in range(5):
        step = np.zeros(5)
        step[k] = 1e-5 * p[k]
        up, down = (
            _distances(camera_of(p + s * step, camera), pose, pixels, plan)[0] for s in (1.0, -1.0)
        )
        by_mirror[:, k] = (up - down) / (2.0 * step[k])
    both = np.column_stack((G, by_mirror))
    information = both.T @ both / sd_px**2
    if mirror_cov is None:
        return np.asarray(np.linalg.inv(information[:3, :3]))
    information[3:, 3:] += np.linalg.inv(mirror_cov)
    return np.asarray(np.linalg.inv(information)[:3, :3])


def _distances(
    camera: FloorCamera, pose: SE2, pixels: np.ndarray, plan: FloorPlan
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of pixels from the border's image, (N,), and by the pose, (N, 3)."""
    walls = np.column_stack((plan.corners, plan.tangents, plan.normals, plan.offsets, plan.lengths))
    values = rays_of_pixels(camera, pixels).values
    rows = np.empty((len(values) + 1, NUM_VALUES))
    num = residuals(values, 1, pose.as_array(), walls, rows)
    return rows[:num, 0], rows[:num, 1:4]


def _foot(pose: SE2, cube: Cube, ways: np.ndarray) -> np.ndarray:
    """Return the distance to a cube's near side along unit vectors of the map, (N,)."""
    own = cube.pose.inverse()
    start = (own @ np.array([[pose.x, pose.y]]))[0]
    turned = ways @ _turn(own.yaw).T
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (-CUBE_M / 2 - start) / turned, (CUBE_M / 2 - start) / turned
    enter, leave = np.minimum(low, high).max(axis=1), np.maximum(low, high).min(axis=1)
    return np.asarray(np.where((enter < leave) & (enter > 0.0), enter, np.inf))


def _turn(yaw: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])
