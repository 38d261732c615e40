"""The pose from the shape of the floor that an omnidirectional camera sees.

In: `floor/mask` (Image mono8), `bearings/<goal class>` (PoseArray, for each goal of the plan: tells
poses apart that fit alike), `initialpose` (PoseWithCovarianceStamped: the same, by hand), `odom`
(Odometry, its pose where TF has none), TF odom->base_link->omni_camera_floor.
Out: `floor_pose` (PoseWithCovarianceStamped of base_link in map; nothing while it is not known),
`floor_pose/candidates` (PoseArray: all poses that fit, the likeliest first), TF map->odom with
`publish_tf`.
"""

from __future__ import annotations

import sys
import time
from typing import Any

from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import Image

from floornav_common.camera_files import load_camera_model
from floornav_common.ros.main import run_node
from floornav_common.ros.messages import image_to_array, poses_to_msg, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import RELIABLE_QOS, SENSOR_QOS, create_publisher
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from floornav_common.time_watch import Throttle
from floornav_common.transform3 import Transform3
from multi_localizer.floor_localizer import FloorLocalizer
from multi_localizer.floor_node_config import FloorLocalizerConfig, FloorPoseConfig
from multi_localizer.floor_plan import load_plan
from multi_localizer.floor_tracker import TrackState
from multi_localizer.goal_evidence import GoalsSeen
from multi_localizer.nodes.floor_report import FloorReport
from multi_localizer.nodes.initial_pose import hear_initial_pose
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.ros_conversions import bearings_from_msg

WARN_PERIOD_NS = 5_000_000_000


class FloorLocalizerNode(FloornavNode):
    """Feeds masks and goals to a FloorLocalizer and publishes the pose."""

    def __init__(self) -> None:
        """Declare, load plan and camera, subscribe, compile, and say ready."""
        super().__init__("floor_localizer")
        config = self._config = declare_config(self, FloorLocalizerConfig)
        self._localizer = self._make_localizer(config)
        self._warnings = Throttle(WARN_PERIOD_NS)
        self._floor_frame = (self.frames.frame_prefix + config.floor_frame).lstrip("/")
        self._outputs = LocalizerOutputs(self, "floor_pose", config.publish_tf)
        self._candidates = create_publisher(self, PoseArray, "floor_pose/candidates", RELIABLE_QOS)
        self._odometry = OdometryFallback(self) if config.use_odom else None
        target = self.frames.odom if config.use_odom else self.frames.base
        self._masks = TransformedSubscription(
            self, Image, "floor/mask", SENSOR_QOS, target, self._on_mask, self._floor_frame
        )
        watchdog = Watchdog(self, self._masks.topic, config.mask_timeout_s)
        self._report = FloorReport(self._localizer, watchdog, self._outputs)
        self.diagnostics.add("floor pose", self._report.status)
        self._log = StateLog(self, self._report.status)
        self.time.on_look(self._look)
        self.transforms.on_restart(self._localizer.tracker.reset)
        for kind in self._plan.goals:
            self._hear_goals(kind)
        hear_initial_pose(self, self._relocate, self._warn)
        self.ready(self._localizer.warm_up)

    def _make_localizer(self, config: FloorLocalizerConfig) -> FloorLocalizer:
        pose = declare_config(self, FloorPoseConfig, on_change=self._tune)
        try:
            self._plan = load_plan(config.plan)
            return FloorLocalizer(load_camera_model(config.camera_model), self._plan, pose)
        except (ValueError, OSError) as error:
            raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error

    def _tune(self, config: FloorPoseConfig) -> None:
        self._localizer.reconfigure(config)

    def _hear_goals(self, kind: str) -> None:
        def take(msg: Any, T_base_sensor: Transform3) -> None:
            seen = GoalsSeen(
                kind, stamp_to_ns(msg.header.stamp), bearings_from_msg(msg),
                T_base_sensor.to_se2(),
            )  # fmt: skip
            self._report.note_goals(seen)
            self._localizer.tracker.see_goals(seen)

        TransformedSubscription(
            self, PoseArray, f"bearings/{kind}", RELIABLE_QOS, self.frames.base, take
        )

    def _on_mask(self, msg: Any, T_target_floor: Transform3) -> None:
        started = time.perf_counter()
        stamp_ns = stamp_to_ns(msg.header.stamp)
        base, floor = self.frames.base, self._floor_frame
        T_base_floor = self.transforms.buffer.lookup(base, floor, stamp_ns).to_se2()
        T_target_base = T_target_floor.to_se2() @ T_base_floor.inverse()
        T_odom_base = T_target_base if self._config.use_odom else None
        try:
            mask = image_to_array(msg, "mono8")
            self._localizer.take_mask(stamp_ns, mask, T_base_floor, T_odom_base)
        except ValueError as error:
            self._report.refuse(str(error))
            return
        self._report.note_mask(1e3 * (time.perf_counter() - started))
        self._publish(msg.header.stamp, T_odom_base)

    def _publish(self, stamp: Any, T_odom_base: SE2 | None) -> None:
        tracker = self._localizer.tracker
        self._say_refusal()
        if tracker.estimate is not None:
            self._outputs.send(stamp, tracker.estimate, T_odom_base)
        is_fit = tracker.state is not TrackState.LOST
        poses = [h.estimate.pose for h in tracker.hypotheses] if is_fit else []
        self._candidates.publish(poses_to_msg(poses, stamp, self.frames.map))

    def _relocate(self, estimate: PoseEstimate) -> None:
        self._localizer.tracker.relocate(estimate)
        self._say_refusal()

    def _say_refusal(self) -> None:
        refusal = self._localizer.tracker.take_refusal()
        if refusal:
            self.get_logger().warning(f"initialpose refused: {refusal}")

    def _look(self) -> None:
        if self._report.is_lost and not self.time.is_stopped:
            self._outputs.stop_tf()

    def _warn(self, text: str) -> None:
        if self._warnings.is_due(self.time.steady_ns()):
            self.get_logger().warning(text)


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(FloorLocalizerNode, args)


if __name__ == "__main__":
    sys.exit(main())
