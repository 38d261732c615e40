"""Colored cones and goals: classes of color, blobs, and the bearings of their middles.

As the team paper's section 2.2 has it: one table over the color cube says the class of every
pixel, pixels of a class that touch are a blob, and a blob's middle is known to a part of a pixel.
Upright things lie along rays from the image's center, so the middle's bearing is the thing's.
"""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numba
import numpy as np
import yaml

from floor_perception.color_model import chromaticity
from floor_perception.color_table import TABLE_EDGE
from floor_perception.marker_ends import bearings_of_ends
from floornav_common.config import param, validate
from floornav_common.config_files import coerce, refuse_unknown
from floornav_common.floor_camera import FloorCamera
from floornav_common.image_size import camera_at_size, shape_doubt

_STEP = 256 // TABLE_EDGE
_MAX_CLASSES = 250


@dataclass(frozen=True, kw_only=True)
class MarkerClass:
    """One class of a file of colors.

    `radius` and the brightness R + G + B (0..765) bound what counts as the color; a blob smaller
    than `min_area_px` is noise.
    """

    color: tuple[float, ...] = param((1.0, 0.0, 0.0), "RGB, 0..1.", ge=0.0, le=1.0)
    radius: float = param(0.08, "Distance of chromaticities (r, g) that still count.", gt=0.0)
    min_brightness: float = param(90.0, "Darker pixels do not count.", ge=0.0, le=765.0)
    min_area_px: int = param(6, "Smallest blob.", unit="px", ge=1)
    has_ends: bool = param(
        False, "Give the bearings of both ends too, as of a goal's posts, on `_left` and `_right`."
    )

    def __post_init__(self) -> None:
        validate(self)
        if len(self.color) != 3 or sum(self.color) == 0.0:
            raise ValueError(f"color must hold red, green, blue, not all 0, got {self.color}")


@dataclass(frozen=True)
class Marker:
    """One blob.

    Attributes:
        bearing: Of its middle in `omni_camera_floor`, rad.
        pixel: Its middle (u, v), to a part of a pixel.
        area_px: Its pixels.
        ends: Bearings of its right and left end, rad; None where its class has none.
    """

    bearing: float
    pixel: tuple[float, float]
    area_px: int
    ends: tuple[float, float] | None = None


def load_marker_classes(path: Path) -> dict[str, MarkerClass]:
    """Read a file of colors: a mapping from class names to the keys of `MarkerClass`.

    Raises:
        ValueError: Not such a mapping, unknown keys, or values out of range.
        OSError: The file cannot be read.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict) or not 0 < len(data) <= _MAX_CLASSES:
        raise ValueError(f"{path}: expected a mapping of 1 to {_MAX_CLASSES} class names")
    return {str(name): _class_of(values, f"{path}: {name}") for name, values in data.items()}


def _class_of(values: Any, where: str) -> MarkerClass:
    if not isinstance(values, Mapping):
        raise ValueError(f"{where}: expected a mapping, got {values!r}")
    hints = typing.get_type_hints(MarkerClass)
    refuse_unknown([str(key) for key in values], list(hints), where)
    try:
        return MarkerClass(**{k: coerce(k, hints[k], v) for k, v in values.items()})
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def class_table(classes: Mapping[str, MarkerClass], order: str) -> np.ndarray:
    """Return the number of the class of each color, from 1 on, 0 for none, (64^3,), uint8.

    A color that several classes take goes to the nearest in parts of their radii.

    Args:
        classes: By name; numbered in their order.
        order: Of the channels in the images: `rgb` or `bgr`.
    """
    middles = (np.arange(TABLE_EDGE) + 0.5) * _STEP
    cube = np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), -1).reshape(-1, 3)
    colors = cube if order == "rgb" else cube[:, ::-1]
    chroma, total = chromaticity(colors), colors.sum(axis=1)
    table = np.zeros(len(cube), dtype=np.uint8)
    nearest = np.ones(len(cube))
    for number, kind in enumerate(classes.values(), start=1):
        off = chroma - chromaticity(255.0 * np.array(kind.color))
        distance = np.hypot(off[:, 0], off[:, 1]) / kind.radius
        is_own = (distance < nearest) & (total >= kind.min_brightness)
        table[is_own], nearest[is_own] = number, distance[is_own]
    return table


class MarkerDetector:
    """Finds the markers of several classes in images of one camera.

    Args:
        camera: The camera over the floor; images of another size are taken as its resized ones.
        classes: By name.
        hidden: Picture whose black pixels see the robot, (H, W), or None.

    Attributes:
        size_doubt: What is doubtful about the images' size; "" if nothing.
    """

    def __init__(
        self,
        camera: FloorCamera,
        classes: Mapping[str, MarkerClass],
        hidden: np.ndarray | None = None,
    ) -> None:
        self._calibrated, self._classes, self._hidden = camera, classes, hidden
        self._tables = {order: class_table(classes, order) for order in ("rgb", "bgr")}
        self._size = (0, 0)
        self._set_size(camera.height_px, camera.width_px)

    def detect(self, image: np.ndarray, order: str) -> dict[str, list[Marker]]:
        """Return the markers of every class, largest first.

        Args:
            image: (H, W, 3), uint8.
            order: Of its channels: `rgb` or `bgr`.

        Raises:
            ValueError: The image has not three channels, or another shape than the camera's.
        """
        if image.ndim != 3 or image.shape[2] != 3:
            raise ValueError(f"image must be (H, W, 3), got {image.shape}")
        height, width = image.shape[:2]
        if (height, width) != self._size:
            self._set_size(height, width)
        counts = np.zeros(len(self._classes) + 1, dtype=np.int64)
        _label(image, self._tables[order], self._is_used, self._labels, counts)
        return {
            name: self._blobs(number, kind) if counts[number] >= kind.min_area_px else []
            for number, (name, kind) in enumerate(self._classes.items(), start=1)
        }

    def _blobs(self, number: int, kind: MarkerClass) -> list[Marker]:
        own = cv2.compare(self._labels, number, cv2.CMP_EQ)
        _, blobs, stats, middles = cv2.connectedComponentsWithStats(own, connectivity=8)
        found = [
            self._marker(k, blobs, stats[k], middles[k], kind)
            for k in range(1, len(stats))
            if stats[k, cv2.CC_STAT_AREA] >= kind.min_area_px
        ]
        return sorted(found, key=lambda marker: -marker.area_px)

    def _marker(
        self, k: int, blobs: np.ndarray, stats: np.ndarray, middle: np.ndarray, kind: MarkerClass
    ) -> Marker:
        bearing, ends = self._bearing(middle), None
        if kind.has_ends:
            u0, v0, width, height, _ = stats
            v, u = np.nonzero(blobs[v0 : v0 + height, u0 : u0 + width] == k)
            pixels = np.stack((u + u0, v + v0), axis=-1).astype(float)
            ends = bearings_of_ends(pixels, bearing, self._camera)
        area = int(stats[cv2.CC_STAT_AREA])
        return Marker(bearing, (float(middle[0]), float(middle[1])), area, ends)

    def _bearing(self, pixel: np.ndarray) -> float:
        x, y, _ = self._camera.floor_rays(pixel)
        return float(np.arctan2(y, x))

    def _set_size(self, height: int, width: int) -> None:
        camera = camera_at_size(self._calibrated, height, width)
        is_used = camera.seen_mask()
        if self._hidden is not None:
            hidden = cv2.resize(self._hidden, (width, height), interpolation=cv2.INTER_NEAREST)
            is_used = is_used & (hidden > 0)
        self._camera, self._is_used, self._size = camera, is_used, (height, width)
        self._labels = np.zeros((height, width), dtype=np.uint8)
        self.size_doubt = shape_doubt(self._calibrated, height, width)


@numba.njit(cache=True, error_model="numpy")
def _label(image, table, is_used, labels, counts):  # type: ignore[no-untyped-def]
    two, six, twelve = np.uint32(2), np.uint32(6), np.uint32(12)
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            label = np.uint8(0)
            if is_used[v, u]:
                a, b, c = image[v, u, 0], image[v, u, 1], image[v, u, 2]
                index = np.uint32(a) >> two << twelve
                index |= np.uint32(b) >> two << six | np.uint32(c) >> two
                label = table[index]
                counts[label] += 1
            labels[v, u] = label
