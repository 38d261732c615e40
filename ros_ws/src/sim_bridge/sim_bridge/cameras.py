"""The cameras of a robot: which rays their pixels take, when they are due, what they see."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera
from sim_bridge.camera_config import OmniCameraConfig, StereoConfig, optical_frame
from sim_bridge.camera_rays import Rays, sorted_rays
from sim_bridge.image_effects import ImageSensor
from sim_bridge.observations import StereoImages
from sim_bridge.robot_model import RobotModel
from sim_bridge.scene import Scene

_EDGE_SOFTNESS_PX = 1.0


class SensorPoses(Protocol):
    """What places a sensor in the world: the physics."""

    def sensor_pose(self, name: str, T_base_sensor: np.ndarray) -> np.ndarray:
        """Return `T_world_sensor`, (4, 4)."""
        ...


@dataclass(frozen=True)
class _Camera:
    T_base_camera: np.ndarray
    rays: Rays
    sensor: ImageSensor


class Cameras:
    """All cameras of one robot.

    Args:
        name: The robot's.
        model: Its model.
        scene: What is around it.
        seed: Of the simulation; each image of each camera has its own noise.
    """

    def __init__(self, name: str, model: RobotModel, scene: Scene, seed: int) -> None:
        self._name, self._scene = name, scene
        scene.light_at(pinhole_rays(1, 1, 1.0, 2, 0.0), np.eye(4))  # compiles, if it is not yet
        omni, stereo = model.config.omni, model.config.stereo
        self._omni: _Camera | None = None
        self._stereo: dict[str, tuple[_Camera, _Camera]] = {}
        if omni is not None:
            key = _key(seed, name, "omni")
            self._omni = _omni_camera(omni, model.mounts[omni.frame], key)
        if stereo is None:
            return
        for pair in stereo.pairs:
            left, right = (
                _pinhole_camera(stereo, model.mounts[frame], _key(seed, name, frame))
                for frame in (optical_frame(pair, side) for side in ("left", "right"))
            )
            self._stereo[pair] = left, right

    def omni(self, poses: SensorPoses, frame: int) -> np.ndarray | None:
        """Return the mirror's image now, the `frame`th, RGB uint8; None without such a camera."""
        return None if self._omni is None else self._image(self._omni, poses, frame)

    def stereo(self, pair: str, poses: SensorPoses, frame: int) -> StereoImages:
        """Return the images of a pair now."""
        left, right = self._stereo[pair]
        return StereoImages(self._image(left, poses, frame), self._image(right, poses, frame))

    def _image(self, camera: _Camera, poses: SensorPoses, frame: int) -> np.ndarray:
        T_world_camera = poses.sensor_pose(self._name, camera.T_base_camera)
        return camera.sensor.expose(self._scene.light_at(camera.rays, T_world_camera), frame)


def mirror_rays(camera: MirrorCamera, samples: int, refine_above: float) -> Rays:
    """Return the rays of a mirror's pixels; none where the mirror is not."""
    directions = camera.rays(_sub_pixels(camera.width_px, camera.height_px, samples))
    is_seen = _radius(camera) <= camera.max_radius_px + _EDGE_SOFTNESS_PX
    return sorted_rays(directions, is_seen, refine_above)


def mirror_sensor(config: OmniCameraConfig, key: tuple[int, ...]) -> ImageSensor:
    """Return what makes images of a mirror's light; `key` seeds the noise."""
    camera = config.camera()
    radius = _radius(camera)
    # The mirror's edge covers a part of the pixels that it crosses.
    gain = np.clip((camera.max_radius_px - radius) / _EDGE_SOFTNESS_PX + 0.5, 0.0, 1.0)
    return ImageSensor(config.image, gain, np.minimum(radius / camera.max_radius_px, 1.0), key)


def pinhole_rays(
    width_px: int, height_px: int, focal_px: float, samples: int, refine_above: float = -1.0
) -> Rays:
    """Return the rays of a pinhole's pixels: x right, y down, z along the view."""
    pixels = _sub_pixels(width_px, height_px, samples)
    middle = np.array([(width_px - 1) / 2.0, (height_px - 1) / 2.0])
    flat = (pixels - middle) / focal_px
    directions = np.concatenate((flat, np.ones((*flat.shape[:-1], 1))), axis=-1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return sorted_rays(directions, np.ones((height_px, width_px), dtype=bool), refine_above)


def _omni_camera(
    config: OmniCameraConfig, T_base_camera: np.ndarray, key: tuple[int, ...]
) -> _Camera:
    camera = config.camera()
    rays = mirror_rays(camera, config.samples, config.refine_above)
    return _Camera(T_base_camera, rays, mirror_sensor(config, key))


def _pinhole_camera(
    config: StereoConfig, T_base_camera: np.ndarray, key: tuple[int, ...]
) -> _Camera:
    width, height = config.width_px, config.height_px
    v, u = np.mgrid[:height, :width]
    edge = np.hypot(u - (width - 1) / 2.0, v - (height - 1) / 2.0)
    sensor = ImageSensor(config.image, np.ones_like(edge), edge / edge.max(), key)
    rays = pinhole_rays(width, height, config.focal_px, config.samples, config.refine_above)
    return _Camera(T_base_camera, rays, sensor)


def _radius(camera: MirrorCamera) -> np.ndarray:
    v, u = np.mgrid[: camera.height_px, : camera.width_px]
    return np.hypot(u - camera.center_u_px, v - camera.center_v_px)


def _sub_pixels(width: int, height: int, samples: int) -> np.ndarray:
    """Return (u, v) of the rays of each pixel, evenly over its square, (height, width, S, 2)."""
    steps = (np.arange(samples) + 0.5) / samples - 0.5
    v, u = np.mgrid[:height, :width]
    dv, du = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    return np.stack((u[:, :, None] + du, v[:, :, None] + dv), axis=-1)


def _key(seed: int, robot: str, sensor: str) -> tuple[int, ...]:
    return seed, zlib.crc32(robot.encode()), zlib.crc32(sensor.encode())
