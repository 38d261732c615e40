"""What the planner hears: scan, odometry, and its pose; each says what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sensor_msgs.msg import LaserScan

from floornav_common.ros.messages import scan_from_msg, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.stuck_scan import StuckScan
from floornav_common.transform_errors import TransformUnavailable
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.nodes.input_missing import InputMissing, age_of, require
from sjmc_planner.nodes.known_inputs import KnownInputs
from sjmc_planner.nodes.odometry_input import OdometryInput
from sjmc_planner.nodes.pose_input import PoseInput
from sjmc_planner.planning import Obstacles, Velocity
from sjmc_planner.scan_mount import mounted


class PlannerInputs:
    """The newest of each input, carried forward to now.

    Args:
        node: The node.
        config: Time limits.
        on_scan: Called after a scan that can be used was taken.

    Attributes:
        known: What is known beside the scan.
        velocity: Gives the measured velocity; see `OdometryInput`.
        pose: Gives the robot's pose in a frame; see `PoseInput`.
    """

    def __init__(
        self, node: FloornavNode, config: LocalPlannerConfig, on_scan: Callable[[], None]
    ) -> None:
        self._node, self._config, self._base = node, config, node.frames.base
        self._on_new_scan = on_scan
        self._scan: tuple[Scan, str, int] | None = None
        self._bad_scan = ""
        self._stuck, self._way, self._is_new = StuckScan(), SE2.identity(), False
        scans = create_subscription(node, LaserScan, "scan", self._on_scan, SENSOR_QOS)
        self._scans = Watchdog(node, scans.topic_name, config.scan_timeout_s)
        self._odometry = OdometryInput(node, config.odom_timeout_s)
        self._poses = PoseInput(node, config.pose_timeout_s)
        self.velocity, self.pose = self._odometry.velocity, self._poses.pose
        self.known = KnownInputs(node, config)

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take other time limits."""
        self._config = config
        self._scans.set_timeout(config.scan_timeout_s)
        self._odometry.set_timeout(config.odom_timeout_s)
        self._poses.set_timeout(config.pose_timeout_s)
        self.known.set_config(config)

    def obstacles(self, velocity: Velocity, moved: SE2, dt: float) -> Obstacles:
        """Return the newest scan, seen from where the robot is now, and what is known beside it.

        Raises:
            InputMissing: If it is not fresh, not usable, the same as before the robot moved, or its
                sensor's place is not known; or as `KnownInputs.beside`.
        """
        self._way = self._way @ moved
        require(self._scans, self._bad_scan)
        assert self._scan is not None
        scan, frame, stamp_ns = self._scan
        self._refuse_stuck(scan)
        try:
            T_base_sensor = self._node.transforms.buffer.lookup(self._base, frame)
            seen = mounted(scan, T_base_sensor)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"{self._scans.topic}: {error}") from error
        age = age_of(self._node, f"{self._scans.topic}:", stamp_ns, self._config.scan_timeout_s)
        seen = Obstacles(seen.scan, _back(velocity, age) @ seen.T_base_sensor)
        return replace(seen, known=self.known.beside(seen, moved, dt, self.pose, velocity))

    def _refuse_stuck(self, scan: Scan) -> None:
        if self._is_new:
            self._stuck.take(scan.ranges, self._way)
            self._is_new = False
        if self._stuck.fault:
            raise InputMissing(f"{self._scans.topic}: {self._stuck.fault}")

    def _on_scan(self, msg: Any) -> None:
        self._scans.feed()
        try:
            scan = scan_from_msg(msg)
            self._scan = scan, msg.header.frame_id, stamp_to_ns(msg.header.stamp)
            self._bad_scan, self._is_new = "", True
        except ValueError as error:
            self._bad_scan = str(error)
            return
        self._on_new_scan()


def _back(velocity: Velocity, age: float) -> SE2:
    return moved_by(velocity, age).inverse()
