"""The pose from landmarks that a camera sees in directions.

In: `bearings/<class>` (PoseArray, for each class of the file `landmarks`, in frames at one place);
with `method: floor` too `floor/mask` (Image mono8: how far away landmarks stand), its camera above
TF base_link->`floor_frame`; TF odom->base_link or `odom` (Odometry): what follows from the motion.
Out: `landmark_pose` (PoseWithCovarianceStamped of base_link in map; nothing while it is not known),
TF map->odom with `publish_tf`.
"""

from __future__ import annotations

import sys
import time
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import Image

from floornav_common.camera_files import load_camera_model
from floornav_common.ros.main import run_node
from floornav_common.ros.messages import image_to_array, ns_to_stamp, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import RELIABLE_QOS, SENSOR_QOS, create_subscription
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from floornav_common.transform_errors import TransformUnavailable
from multi_localizer.landmark_config import LandmarkConfig, LandmarkNodeConfig, LandmarkTimeConfig
from multi_localizer.landmark_localizer import LandmarkLocalizer
from multi_localizer.landmark_views import LandmarkViews
from multi_localizer.landmarks import load_landmarks
from multi_localizer.nodes.landmark_report import LandmarkReport
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.nodes.stamped_input import StampedInput
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.ros_conversions import bearings_from_msg

MASK = "floor/mask"
LOG_PERIOD_S = 5.0


class LandmarkLocalizerNode(FloornavNode):
    """Puts together what is seen at one moment, and publishes the pose it gives."""

    def __init__(self) -> None:
        """Declare, load the landmarks, subscribe, and say ready."""
        super().__init__("landmark_localizer")
        config = self._config = declare_config(self, LandmarkNodeConfig)
        self._floor_frame = (self.frames.frame_prefix + config.floor_frame).lstrip("/")
        self._localizer = self._make_localizer(config)
        self._seen = StampedInput(self, config.wait_s, self._locate)
        self._outputs = LocalizerOutputs(self, "landmark_pose", config.publish_tf)
        self._odometry = OdometryFallback(self)
        self._watchdog = Watchdog(self, "bearings", config.input_timeout_s)
        self._report = LandmarkReport(
            self, self._watchdog, self._outputs, self._seen.groups, config.input_timeout_s,
            self._localizer.views.kinds,
        )  # fmt: skip
        self.diagnostics.add("landmark pose", self._report.status)
        self._log = StateLog(self, self._report.status, period_s=LOG_PERIOD_S)
        self._topics = [
            TransformedSubscription(
                self, PoseArray, f"bearings/{kind}", RELIABLE_QOS, self.frames.base,
                partial(self._on_bearings, kind),
            )
            for kind in self._localizer.views.kinds
        ]  # fmt: skip
        if config.method == "floor":
            create_subscription(self, Image, MASK, self._on_mask, SENSOR_QOS)
            self._report.watch_masks(MASK)
        self.transforms.on_restart(self._seen.groups.clear)
        self.transforms.on_restart(self._localizer.tracker.clear)
        self.time.on_look(self._look)
        self.ready()

    def _make_localizer(self, config: LandmarkNodeConfig) -> LandmarkLocalizer:
        tuning = declare_config(self, LandmarkConfig, on_change=self._tune)
        times = declare_config(self, LandmarkTimeConfig, on_change=self._tune)
        try:
            is_floor = config.method == "floor"
            camera = load_camera_model(config.camera_model) if is_floor else None
            views = LandmarkViews(load_landmarks(config.landmarks), tuning, camera)
        except (ValueError, OSError) as error:
            raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error
        return LandmarkLocalizer(views, times.track)

    def _tune(self, config: LandmarkConfig | LandmarkTimeConfig) -> None:
        self._localizer.reconfigure(config)

    def _on_bearings(self, kind: str, msg: Any, T_base_sensor: Transform3) -> None:
        self._watchdog.feed()
        bearings = bearings_from_msg(msg), T_base_sensor.to_se2()
        self._seen.add(kind, stamp_to_ns(msg.header.stamp), bearings)

    def _on_mask(self, msg: Any) -> None:
        try:
            mask = image_to_array(msg, "mono8")
        except ValueError as error:
            self._report.refuse_mask(str(error))
            return
        self._report.note_mask()
        self._seen.add(MASK, stamp_to_ns(msg.header.stamp), mask)

    def _look(self) -> None:
        if self._report.is_lost and not self.time.is_stopped:
            self._outputs.stop_tf()

    def _locate(self, stamp_ns: int, group: dict[str, Any]) -> None:
        mask: np.ndarray | None = group.pop(MASK, None)
        if not group:
            return
        started, T_odom_base = time.perf_counter(), self._odometry_at(stamp_ns)
        try:
            at = (self.frames.base, self._floor_frame, stamp_ns)
            T_base_floor = None if mask is None else self._at(*at)
            answer = self._localizer.take(stamp_ns, group, mask, T_base_floor, T_odom_base)
        except (ValueError, TransformUnavailable) as error:
            self._report.refuse(str(error))
            return
        self._report.note(answer, 1e3 * (time.perf_counter() - started))
        if answer.pose is not None:
            self._outputs.send(ns_to_stamp(stamp_ns), answer.pose, T_odom_base)

    def _odometry_at(self, stamp_ns: int) -> SE2 | None:
        try:
            return self._at(self.frames.odom, self.frames.base, stamp_ns)
        except (TransformUnavailable, ValueError):
            return None

    def _at(self, target: str, source: str, stamp_ns: int) -> SE2:
        return self.transforms.buffer.lookup(target, source, stamp_ns).to_se2()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(LandmarkLocalizerNode, args)


if __name__ == "__main__":
    sys.exit(main())
