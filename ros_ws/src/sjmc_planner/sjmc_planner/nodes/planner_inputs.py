"""What the planner hears: scan, odometry, and its pose; each says what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nav_msgs.msg import Odometry
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
from sjmc_planner.limited_motion import moved_by, seen_from
from sjmc_planner.nodes.input_missing import InputMissing, fixed_frame
from sjmc_planner.nodes.known_inputs import KnownInputs
from sjmc_planner.planning import Obstacles, Velocity
from sjmc_planner.ros_conversions import velocity_from_msg
from sjmc_planner.scan_mount import mounted

_ANOTHER_CLOCK_S = 1e8  # three years


class PlannerInputs:
    """The newest of each input, carried forward to now.

    Args:
        node: The node.
        config: Time limits.
        on_scan: Called after a scan that can be used was taken.

    Attributes:
        known: What is known beside the scan.
    """

    def __init__(
        self, node: FloornavNode, config: LocalPlannerConfig, on_scan: Callable[[], None]
    ) -> None:
        self._node, self._config, self._base = node, config, node.frames.base
        self._on_new_scan = on_scan
        self._scan: tuple[Scan, str, int] | None = None
        self._twist: tuple[Velocity, str, int] | None = None
        self._bad_scan = self._bad_odometry = ""
        self._stuck, self._way, self._is_new = StuckScan(), SE2.identity(), False
        scans = create_subscription(node, LaserScan, "scan", self._on_scan, SENSOR_QOS)
        odometry = create_subscription(node, Odometry, "odom", self._on_odom, SENSOR_QOS)
        self._scans = Watchdog(node, scans.topic_name, config.scan_timeout_s)
        self._odometry = Watchdog(node, odometry.topic_name, config.odom_timeout_s)
        self.known = KnownInputs(node, config)

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take other time limits."""
        self._config = config
        self._scans.set_timeout(config.scan_timeout_s)
        self._odometry.set_timeout(config.odom_timeout_s)
        self.known.set_config(config)

    def velocity(self) -> Velocity:
        """Return the measured velocity.

        Raises:
            InputMissing: If odometry is not fresh, not usable, or of a frame not known.
        """
        self._require(self._odometry, self._bad_odometry)
        assert self._twist is not None
        velocity, frame, stamp_ns = self._twist
        self._age(f"{self._odometry.topic}:", stamp_ns, self._config.odom_timeout_s)
        try:
            T_base_child = self._node.transforms.buffer.lookup(self._base, frame or self._base)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"{self._odometry.topic}: child_frame_id: {error}") from error
        return seen_from(velocity, T_base_child.to_se2())

    def obstacles(self, velocity: Velocity, moved: SE2, dt: float) -> Obstacles:
        """Return the newest scan, seen from where the robot is now, and what is known beside it.

        Raises:
            InputMissing: If it is not fresh, not usable, the same as before the robot moved, or its
                sensor's place is not known; or as `KnownInputs.beside`.
        """
        self._way = self._way @ moved
        self._require(self._scans, self._bad_scan)
        assert self._scan is not None
        scan, frame, stamp_ns = self._scan
        self._refuse_stuck(scan)
        try:
            T_base_sensor = self._node.transforms.buffer.lookup(self._base, frame)
            seen = mounted(scan, T_base_sensor)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"{self._scans.topic}: {error}") from error
        age = self._age(f"{self._scans.topic}:", stamp_ns, self._config.scan_timeout_s)
        seen = Obstacles(seen.scan, _back(velocity, age) @ seen.T_base_sensor)
        return replace(seen, known=self.known.beside(seen, moved, dt, self.pose, velocity))

    def _refuse_stuck(self, scan: Scan) -> None:
        if self._is_new:
            self._stuck.take(scan.ranges, self._way)
            self._is_new = False
        if self._stuck.fault:
            raise InputMissing(f"{self._scans.topic}: {self._stuck.fault}")

    def pose(self, frame: str, velocity: Velocity) -> SE2:
        """Return the robot's pose in a frame, carried forward from the newest known.

        Raises:
            InputMissing: If it is not known, older than `pose_timeout_s` or as far ahead of now,
                or if the frame is the robot's own: a goal in it would move on with the robot.
        """
        buffer, base = self._node.transforms.buffer, self._base
        try:
            T_frame_base = buffer.lookup(frame, base).to_se2()
            stamp_ns = buffer.newest_common_stamp(frame, base)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"pose: {error}") from error
        if not stamp_ns:
            raise InputMissing(fixed_frame(frame))
        age = self._age(f"pose: '{frame}' to '{base}':", stamp_ns, self._config.pose_timeout_s)
        return T_frame_base @ moved_by(velocity, age)

    def _age(self, what: str, stamp_ns: int, timeout: float) -> float:
        """Return how old a stamp is, s; refuse one from too long ago, or as far ahead of now."""
        age = (self._node.get_clock().now().nanoseconds - stamp_ns) * 1e-9
        if abs(age) > _ANOTHER_CLOCK_S:
            raise InputMissing(f"{what} stamped by another clock: use_sim_time?")
        if age < -timeout:
            raise InputMissing(f"{what} stamped {-age:.1f} s in the future: two clocks?")
        if age > timeout:
            raise InputMissing(f"{what} its stamp is {age:.1f} s old")
        return max(0.0, age)

    @staticmethod
    def _require(watchdog: Watchdog, fault: str) -> None:
        if not watchdog.is_fresh:
            raise InputMissing(f"{watchdog.topic}: {watchdog.status().message}")
        if fault:
            raise InputMissing(f"{watchdog.topic}: {fault}")

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

    def _on_odom(self, msg: Any) -> None:
        self._odometry.feed()
        try:
            velocity = velocity_from_msg(msg.twist.twist)
            self._twist = velocity, msg.child_frame_id, stamp_to_ns(msg.header.stamp)
            self._bad_odometry = ""
        except ValueError as error:
            self._bad_odometry = str(error)


def _back(velocity: Velocity, age: float) -> SE2:
    return moved_by(velocity, age).inverse()
