"""From images of one camera to floor mask and free space (floor paper, 3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from floor_perception.color_model import FloorColor, differs
from floor_perception.color_table import color_table
from floor_perception.color_tracker import ColorTracker
from floor_perception.config import FloorDetectorConfig
from floor_perception.floor_mask import FloorMasker, closing_px
from floor_perception.free_space import NOT_SEEN, floor_areas, ratios_and_ranges
from floor_perception.glare import GlareFinder
from floor_perception.polar_template import PolarTemplate, make_template, row_spans
from floornav_common.floor_camera import FloorCamera
from floornav_common.image_size import camera_at_size, shape_doubt
from floornav_common.scan import Scan


@dataclass(frozen=True)
class FloorResult:
    """What one image shows.

    Attributes:
        mask: 255 where the floor is, else 0, (H, W), uint8.
        ratios: r_ij, (J, I).
        scan: Free space in `omni_camera_floor`; `inf` free to the horizon, NaN not seen, `-inf`
            not even the first ring is free.
    """

    mask: np.ndarray
    ratios: np.ndarray
    scan: Scan

    @property
    def coverage(self) -> float:
        """Share of directions that say something."""
        return float(1.0 - np.isnan(self.scan.ranges).mean())


class FloorDetector:
    """The whole way from image to free space.

    Args:
        camera: The camera over the floor; images of another size are taken as its resized ones.
        config: Colors, mask, template.
        hidden: Picture whose black pixels see the robot, (H, W), or None.
        color: The floor's color to start with; None learns it from the first image.

    Attributes:
        size_doubt: What is doubtful about the images' size; "" if nothing.
    """

    def __init__(
        self,
        camera: FloorCamera,
        config: FloorDetectorConfig,
        hidden: np.ndarray | None = None,
        color: FloorColor | None = None,
    ) -> None:
        self._calibrated, self._config, self._hidden = camera, config, hidden
        self._tables: dict[str, np.ndarray] = {}
        self._set_size(camera.height_px, camera.width_px, color)

    @property
    def color(self) -> FloorColor | None:
        """The floor's color now."""
        return self.tracker.color

    def detect(self, image: np.ndarray, order: str, stamp_ns: int) -> FloorResult | None:
        """Return mask and free space; None while the floor's color is not known.

        Args:
            image: (H, W, 3), uint8.
            order: Of its channels: `rgb` or `bgr`.
            stamp_ns: When it was taken.

        Raises:
            ValueError: The image has not three channels or another shape than the camera's, or no
                floor can be seen in it.
        """
        self.track(image, order, stamp_ns)
        if self.tracker.color is None:
            return None
        if order not in self._tables:
            self._tables[order] = color_table(self.tracker.color, self._config.color, order)
        mask = self.masker.mask(image, self._tables[order])
        ratios, ranges = ratios_and_ranges(
            floor_areas(mask, self.template), self.template, self._config.template.free_share
        )
        is_glare = self.glare.unseen(
            image, ratios, self._config.template.free_share, self._config.color.glare_share
        )
        ranges[is_glare] = NOT_SEEN
        return FloorResult(mask, ratios, self._scan(ranges))

    def track(self, image: np.ndarray, order: str, stamp_ns: int) -> None:
        """Let the floor's color follow an image without looking for free space; as `detect`."""
        if image.ndim != 3 or image.shape[2] != 3:
            raise ValueError(f"image must be (H, W, 3), got {image.shape}")
        height, width = image.shape[:2]
        if (height, width) != self._size:
            self._set_size(height, width, self.color)
        if self.tracker.update(image, order, stamp_ns) and self._has_moved():
            self._tables.clear()
            self._table_color = self.tracker.color

    def ring(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels around the robot, (N, 3), and where they lie on the floor, (N, 2), m.

        Args:
            image: (H, W, 3), uint8.
        """
        if image.shape[:2] != self._size:
            height, width = image.shape[:2]
            self._set_size(height, width, self.color)
        pixels, points = self._ring
        return image[pixels[:, 0], pixels[:, 1]], points

    def reset(self) -> None:
        """Forget the floor's color: the next image shows it anew."""
        self._start_tracking(None)

    def reconfigure(self, config: FloorDetectorConfig) -> None:
        """Go on with other settings; the floor's color is kept.

        Raises:
            ValueError: The camera does not fit them; the old ones stay.
        """
        old, self._config = self._config, config
        try:
            self._set_size(*self._size, self.color)
        except ValueError:
            self._config = old
            raise

    def _scan(self, ranges: np.ndarray) -> Scan:
        template = self.template
        return Scan(
            ranges=ranges,
            angle_min=float(template.bearings[0]),
            angle_increment=template.angle_increment,
            range_min=float(template.edges[0]),
            range_max=float(template.edges[-1]),
        )

    def _set_size(self, height: int, width: int, color: FloorColor | None) -> None:
        """Make template, mask and ring for images of a size."""
        config = self._config
        camera = camera_at_size(self._calibrated, height, width)
        is_hidden = None
        if self._hidden is not None:
            hidden = cv2.resize(self._hidden, (width, height), interpolation=cv2.INTER_NEAREST)
            is_hidden = hidden == 0
        template = make_template(camera, config.template, is_hidden)
        masker = make_masker(camera, config, template, is_hidden)
        self.camera, self.template, self.masker = camera, template, masker
        self.glare = GlareFinder(template)
        self._ring = ring_pixels(camera, config, is_hidden)
        self._size = (height, width)
        self.size_doubt = shape_doubt(self._calibrated, height, width)
        self._start_tracking(color)

    def _start_tracking(self, color: FloorColor | None) -> None:
        self.tracker = ColorTracker(self._config.color, *self._ring, color)
        self._tables.clear()
        self._table_color = color

    def _has_moved(self) -> bool:
        old, new = self._table_color, self.tracker.color
        return old is None or new is None or differs(old, new)


def make_masker(
    camera: FloorCamera,
    config: FloorDetectorConfig,
    template: PolarTemplate,
    is_hidden: np.ndarray | None,
) -> FloorMasker:
    """Return what makes masks: all that the camera sees of the floor, not only the template."""
    distance = _floor_distance(camera)
    is_robot = distance < template.edges[0]
    if is_hidden is not None:
        is_robot |= is_hidden & np.isfinite(distance)
    is_used = np.isfinite(distance) & ~is_robot
    if not is_used.any():
        size = f"{camera.width_px} x {camera.height_px}"
        raise ValueError(f"images must show floor beyond the robot, none is seen at {size} pixels")
    bridge = closing_px(config.mask.mark_m, px_per_m(camera, float(template.edges[0])))
    return FloorMasker(row_spans(is_used), is_used, is_robot, config.mask.speck_px, bridge)


def px_per_m(camera: FloorCamera, distance: float) -> float:
    """Return how large a camera sees the floor at a distance, at most, pixels per m."""
    angles = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    points = distance * np.stack((np.cos(angles), np.sin(angles)), -1)
    jacobian = camera.floor_jacobian(camera.floor_pixels(points))
    known = jacobian[np.isfinite(jacobian).all(axis=(1, 2))]
    smallest = np.linalg.svd(known, compute_uv=False)[:, -1]
    if not len(smallest):
        raise ValueError(f"the camera must see the floor {distance:g} m away, it does nowhere")
    return float(1.0 / smallest.min())


def ring_pixels(
    camera: FloorCamera, config: FloorDetectorConfig, is_hidden: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return row and column (N, 2) and place on the floor (N, 2), m, of the ring's pixels."""
    distance = _floor_distance(camera)
    low = config.template.range_min_m
    is_ring = (distance >= low) & (distance < low + config.color.ring_m)
    if is_hidden is not None:
        is_ring &= ~is_hidden
    pixels = np.argwhere(is_ring)
    return pixels, camera.floor_points(pixels[:, ::-1].astype(float))


def _floor_distance(camera: FloorCamera) -> np.ndarray:
    """Return the distance on the floor of each pixel, (H, W), m; inf where no floor is seen."""
    v, u = np.mgrid[: camera.height_px, : camera.width_px]
    points = camera.floor_points(np.stack((u, v), -1).astype(float))
    distance = np.hypot(points[..., 0], points[..., 1])
    return np.where(np.isfinite(distance), distance, np.inf)
