"""Method 2 (team paper, 2.3): landmarks in the image projected to the floor, distance and bearing.

Along a landmark's bearing the floor ends at its foot: the outermost floor pixel of the mask there
is how far away it stands, r = f(R). With distance and bearing a landmark is a point in the robot's
frame; two or more points laid over those of the map give the pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2

_STEP_PX = 0.25
_FLOOR_RUN_PX = 1.5  # less floor than this between two things is noise
_TOUCHING_PX = 1.5  # floor up to the edge of the image, or of the horizon, ends at no foot
_FAR_M = 1e4


@dataclass(frozen=True)
class FloorEnd:
    """Where the floor ends in a direction.

    Attributes:
        distance: From the camera's foot, m.
        meters_per_px: What a pixel along the ray is there, m.
    """

    distance: float
    meters_per_px: float


def floor_fix(points: np.ndarray, seen: np.ndarray) -> SE2 | None:
    """Return the pose that lays seen points over those of the map, all weighing the same.

    Args:
        points: Positions in the map, (N, 2), m.
        seen: The same in the robot's frame, (N, 2), m.

    Returns:
        The pose with the least sum of squared distances; None for fewer than two places.
    """
    if len(points) < 2:
        return None
    a, b = seen - seen.mean(axis=0), points - points.mean(axis=0)
    cos, sin = float((a * b).sum()), float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    if math.hypot(cos, sin) < 1e-9:
        return None
    turn = SE2(0.0, 0.0, math.atan2(sin, cos))
    x, y = points.mean(axis=0) - (turn @ seen.mean(axis=0)[None])[0]
    return SE2(float(x), float(y), turn.yaw)


class FloorEnds:
    """Finds where the floor ends along bearings in masks of one camera.

    Args:
        camera: As large as the masks.
    """

    def __init__(self, camera: FloorCamera) -> None:
        self._camera = camera

    def end(self, mask: np.ndarray, bearing: float) -> FloorEnd | None:
        """Return where the floor ends in a direction.

        Args:
            mask: Not 0 where floor is, (H, W), uint8.
            bearing: In `omni_camera_floor`, rad.

        Returns:
            None where no floor is seen in that direction, or it reaches the end of what is seen.

        Raises:
            ValueError: The mask has another size than the camera's images.
        """
        if mask.shape != (self._camera.height_px, self._camera.width_px):
            raise ValueError(
                f"mask must be {self._camera.width_px} x {self._camera.height_px} pixels, got "
                f"{mask.shape[1]} x {mask.shape[0]}"
            )
        pixels, steps = self._ray(bearing)
        if len(pixels) < 2:
            return None
        u, v = np.rint(pixels).astype(int).T
        is_floor = mask[v, u] > 0
        last = _outermost(is_floor, steps)
        if last is None or steps[-1] - steps[last] < _TOUCHING_PX:
            return None
        ends = self._camera.floor_points(pixels[last : last + 2])
        near, far = np.hypot(*ends.T)
        scale = float((far - near) / max(steps[last + 1] - steps[last], 1e-9))
        if not math.isfinite(scale):
            return None
        return FloorEnd(float(0.5 * (near + far)), scale)

    def _ray(self, bearing: float) -> tuple[np.ndarray, np.ndarray]:
        """Return pixels (N, 2) along a bearing, inside out, and their way in the image, px."""
        way = np.array([math.cos(bearing), math.sin(bearing)])
        distances = np.geomspace(1e-2 * self._camera.height_m, _FAR_M, 4000)
        pixels = self._camera.floor_pixels(distances[:, None] * way)
        is_seen = np.all(np.isfinite(pixels), axis=1) & self._is_inside(pixels)
        pixels = pixels[is_seen & self._camera.camera.sees(np.nan_to_num(pixels))]
        if len(pixels) < 2:
            return pixels, np.zeros(len(pixels))
        steps = np.concatenate(([0.0], np.hypot(*np.diff(pixels, axis=0).T).cumsum()))
        at = np.arange(0.0, steps[-1], _STEP_PX)
        return np.stack([np.interp(at, steps, column) for column in pixels.T], axis=-1), at

    def _is_inside(self, pixels: np.ndarray) -> np.ndarray:
        size = np.array([self._camera.width_px, self._camera.height_px])
        with np.errstate(invalid="ignore"):
            return np.asarray(np.all((pixels >= -0.49) & (pixels <= size - 0.51), axis=1))


def _outermost(is_floor: np.ndarray, steps: np.ndarray) -> int | None:
    """Return the index of the last floor of the outermost run that is long enough."""
    edges = np.diff(np.concatenate(([0], is_floor.astype(np.int8), [0])))
    starts, ends = np.nonzero(edges == 1)[0], np.nonzero(edges == -1)[0] - 1
    for start, end in zip(starts[::-1], ends[::-1], strict=True):
        if steps[end] - steps[start] >= _FLOOR_RUN_PX:
            return int(end)
    return None
