"""One view of the landmarks: bearings, and the floor's mask where it tells distances."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.image_size import camera_at_size
from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting
from multi_localizer.landmark_floor import FloorEnds
from multi_localizer.landmark_locator import LandmarkFix, LandmarkLocator
from multi_localizer.landmarks import Landmarks
from multi_localizer.pose_estimate import PoseEstimate

_SAME_PLACE_M = 0.01


class LandmarkViews:
    """Turns views into poses of the sensor.

    Args:
        landmarks: By class.
        config: Deviations and gates.
        camera: The camera of the masks; None for bearings alone (method 1).
    """

    def __init__(
        self, landmarks: Landmarks, config: LandmarkConfig, camera: FloorCamera | None = None
    ) -> None:
        self._landmarks, self._calibrated = landmarks, camera
        self._ends: dict[tuple[int, ...], FloorEnds] = {}
        self.reconfigure(config)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The classes of landmarks."""
        return tuple(self._landmarks)

    def reconfigure(self, config: LandmarkConfig) -> None:
        """Go on with other values."""
        self._config = config
        self._locator = LandmarkLocator(self._landmarks, config)

    def locate(
        self,
        bearings: Mapping[str, np.ndarray],
        mask: np.ndarray | None = None,
        expected: PoseEstimate | None = None,
    ) -> LandmarkFix:
        """Return the pose of the sensor that a view gives.

        Args:
            bearings: By class, (K,) each, rad.
            mask: Of the floor at the same moment, (H, W), uint8; None where there is none.
            expected: Where the sensor should be; None if that is not known.

        Raises:
            ValueError: The mask has another shape than the camera's images.
        """
        return self._locator.locate(self.sightings(bearings, mask), expected)

    def sightings(
        self, bearings: Mapping[str, np.ndarray], mask: np.ndarray | None = None
    ) -> list[Sighting]:
        """Return what is seen, with distances where the mask shows feet of landmarks."""
        if mask is None or self._calibrated is None:
            ends = None
        else:
            ends = self._ends_of(self._calibrated, mask.shape)
        return [
            self._sighting(kind, float(bearing), ends, mask)
            for kind, values in bearings.items()
            for bearing in values
        ]

    def _sighting(
        self, kind: str, bearing: float, ends: FloorEnds | None, mask: np.ndarray | None
    ) -> Sighting:
        sd = self._config.bearing_sd_rad
        if ends is None or mask is None or not math.isfinite(bearing) or not self._has_foot(kind):
            return Sighting(kind, bearing, sd)
        end = ends.end(mask, bearing)
        if end is None:
            return Sighting(kind, bearing, sd)
        distance = end.distance + self._config.floor_offset_px * end.meters_per_px
        return Sighting(kind, bearing, sd, distance, self._config.floor_sd_px * end.meters_per_px)

    def _has_foot(self, kind: str) -> bool:
        """Tell whether floor ends at the very point that bearings of a class are of.

        The middle of a wide thing is no point of it.
        """
        marks = self._landmarks.get(kind, ())
        return all(len(mark.corners) == 1 or mark.seen != "middle" for mark in marks)

    def _ends_of(self, camera: FloorCamera, shape: tuple[int, ...]) -> FloorEnds:
        if shape not in self._ends:
            self._ends = {shape: FloorEnds(camera_at_size(camera, *shape))}
        return self._ends[shape]


def turned_together(
    views: Mapping[str, tuple[np.ndarray, SE2]], T_base_sensor: SE2
) -> dict[str, np.ndarray]:
    """Return bearings in one frame that were taken in frames turned against it.

    Args:
        views: By class: bearings, (K,), rad, and the sensor's frame in that of the base.
        T_base_sensor: The frame they are to be in, in that of the base.

    Raises:
        ValueError: A sensor stands at another place than that frame: its bearings are no others.
    """
    together = {}
    for kind, (bearings, T_base_own) in views.items():
        off = math.hypot(T_base_own.x - T_base_sensor.x, T_base_own.y - T_base_sensor.y)
        if off > _SAME_PLACE_M:
            raise ValueError(f"the bearings of {kind} are seen from {off:.2f} m beside the others")
        together[kind] = bearings + (T_base_own.yaw - T_base_sensor.yaw)
    return together
