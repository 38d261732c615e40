"""What the planner hears of odometry: how fast the robot moves."""

from __future__ import annotations

from typing import Any

from nav_msgs.msg import Odometry

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.transform_errors import TransformUnavailable
from sjmc_planner.limited_motion import seen_from
from sjmc_planner.nodes.input_missing import InputMissing, age_of, require
from sjmc_planner.planning import Velocity
from sjmc_planner.ros_conversions import velocity_from_msg


class OdometryInput:
    """The newest twist on `odom`.

    Args:
        node: The node.
        timeout_s: Silence allowed, and age.
    """

    def __init__(self, node: FloornavNode, timeout_s: float) -> None:
        self._node, self._timeout_s = node, timeout_s
        self._twist: tuple[Velocity, str, int] | None = None
        self._fault = ""
        subscription = create_subscription(node, Odometry, "odom", self._on_odom, SENSOR_QOS)
        self._watchdog = Watchdog(node, subscription.topic_name, timeout_s)

    def set_timeout(self, timeout_s: float) -> None:
        """Take another time limit."""
        self._timeout_s = timeout_s
        self._watchdog.set_timeout(timeout_s)

    def velocity(self) -> Velocity:
        """Return the measured velocity.

        Raises:
            InputMissing: If odometry is not fresh, not usable, or of a frame not known.
        """
        require(self._watchdog, self._fault)
        assert self._twist is not None
        velocity, frame, stamp_ns = self._twist
        topic, base = self._watchdog.topic, self._node.frames.base
        age_of(self._node, f"{topic}:", stamp_ns, self._timeout_s)
        try:
            T_base_child = self._node.transforms.buffer.lookup(base, frame or base)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"{topic}: child_frame_id: {error}") from error
        return seen_from(velocity, T_base_child.to_se2())

    def _on_odom(self, msg: Any) -> None:
        self._watchdog.feed()
        try:
            velocity = velocity_from_msg(msg.twist.twist)
            self._twist = velocity, msg.child_frame_id, stamp_to_ns(msg.header.stamp)
            self._fault = ""
        except ValueError as error:
            self._fault = str(error)
