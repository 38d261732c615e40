"""From views of landmarks and motion to the robot's pose: locate, then let views confirm it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig, LandmarkTimeConfig, LandmarkTrackConfig
from multi_localizer.landmark_locator import LandmarkFix
from multi_localizer.landmark_tracker import LandmarkTracker
from multi_localizer.landmark_views import LandmarkViews, turned_together
from multi_localizer.pose_estimate import PoseEstimate, moved


@dataclass(frozen=True)
class LandmarkAnswer:
    """What came of a view.

    Attributes:
        fix: By the view alone.
        pose: Of base_link, to be given; None if it is not.
        why_not: Why the view's pose is not given; "" if it is, or if the view has none.
        num_seen: Bearings by class.
    """

    fix: LandmarkFix
    pose: PoseEstimate | None
    why_not: str
    num_seen: Mapping[str, int]


class LandmarkLocalizer:
    """Keeps the robot's pose among landmarks.

    Args:
        views: Finds poses in views.
        config: How views confirm each other.
    """

    def __init__(self, views: LandmarkViews, config: LandmarkTrackConfig) -> None:
        self.views, self.tracker = views, LandmarkTracker(config)

    def reconfigure(self, config: LandmarkConfig | LandmarkTimeConfig) -> None:
        """Go on with other values."""
        if isinstance(config, LandmarkConfig):
            self.views.reconfigure(config)
        else:
            self.tracker.config = config.track

    def take(
        self,
        stamp_ns: int,
        seen: Mapping[str, tuple[np.ndarray, SE2]],
        mask: np.ndarray | None,
        T_base_floor: SE2 | None,
        T_odom_base: SE2 | None,
    ) -> LandmarkAnswer:
        """Take what is seen at one moment.

        Args:
            stamp_ns: Its stamp.
            seen: By class: bearings, (K,), rad, and the sensor's frame in that of the base.
            mask: Of the floor, (H, W), uint8; None where there is none.
            T_base_floor: Where the floor below the mask's camera is on the robot; None: the pose is
                found of the sensor of the first bearings.
            T_odom_base: Where odometry has the robot then; None without odometry.

        Raises:
            ValueError: Bearings of another place, or a mask of another shape than the camera's.
        """
        first: SE2 = next(iter(seen.values()))[1]
        T_base_sensor = first if T_base_floor is None else T_base_floor
        bearings = turned_together(seen, T_base_sensor)
        expected = self.tracker.expected(stamp_ns, T_odom_base)
        there = None if expected is None else moved(expected, T_base_sensor)
        fix = self.views.locate(bearings, mask, there)
        base = None if fix.estimate is None else moved(fix.estimate, T_base_sensor.inverse())
        why_not = self.tracker.update(stamp_ns, base, T_odom_base, fix.is_elsewhere)
        num_seen = {kind: len(values) for kind, values in bearings.items()}
        return LandmarkAnswer(fix, None if why_not else base, why_not, num_seen)
