"""From the light on a lens to the bytes of an image: blur, vignetting, exposure, noise."""

from __future__ import annotations

import cv2
import numba
import numpy as np

from sim_bridge.camera_config import ImageConfig

_POOL = 1 << 21


class ImageSensor:
    """A lens and a sensor with a noise of its own.

    Noise is cut from one long row of numbers at a place drawn for each image: drawing a number a
    value would cost more than the rest of the picture. It depends on key and frame alone, so an
    image that is never taken changes no other.

    Args:
        config: Its figures.
        gain: What the lens lets through at each pixel before vignetting, (height, width).
        edge: Distance of each pixel from the middle, 1 at the image's edge, (height, width).
        key: Seeds of the noise.
    """

    def __init__(
        self, config: ImageConfig, gain: np.ndarray, edge: np.ndarray, key: tuple[int, ...]
    ) -> None:
        self._config, self._key = config, key
        falloff = gain * (1.0 - config.vignetting * edge**2)
        tint = 255.0 * config.exposure * np.array(config.color)
        self._gain = (falloff[:, :, None] * tint).astype(np.float32)
        count = max(_POOL, 2 * self._gain.size)
        self._pool = np.random.default_rng(key).standard_normal(count, dtype=np.float32)
        self._develop(np.zeros(0, np.float32), np.zeros(0, np.float32), 0)  # compiles

    def expose(self, light: np.ndarray, frame: int) -> np.ndarray:
        """Return the `frame`th image, RGB uint8, of light (height, width, 3) float32."""
        sd = self._config.blur_sd_px
        blurred = cv2.GaussianBlur(light, (0, 0), sd) if sd > 0.0 else light
        rng = np.random.default_rng((*self._key, frame))
        start = int(rng.integers(len(self._pool) - light.size + 1))
        return self._develop(blurred.ravel(), self._gain.ravel(), start).reshape(light.shape)

    def _develop(self, light: np.ndarray, gain: np.ndarray, start: int) -> np.ndarray:
        image = np.empty(len(light), dtype=np.uint8)
        noise = self._pool[start : start + len(light)]
        dark, per_level = self._config.noise_sd**2, self._config.shot_noise
        _expose(light, gain, noise, np.float32(dark), np.float32(per_level), image)
        return image


@numba.njit(cache=True, error_model="numpy")
def _expose(light, gain, noise, dark, per_level, image):  # type: ignore[no-untyped-def]
    for k in range(len(image)):
        level = min(light[k] * gain[k], np.float32(1000.0))
        level += np.sqrt(dark + per_level * level) * noise[k]
        image[k] = np.uint8(min(max(level + np.float32(0.5), np.float32(0.0)), np.float32(255.0)))
