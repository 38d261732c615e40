"""The topics of one simulated robot."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, String

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import (
    LATCHED_QOS,
    RELIABLE_QOS,
    create_publisher,
    create_subscription,
)
from floornav_common.ros.transforms import StaticTransformBroadcaster, TransformBroadcaster
from floornav_common.transform3 import Transform3
from sim_bridge.drive import Velocity, limitation, refusal
from sim_bridge.nodes.camera_port import CameraPort
from sim_bridge.nodes.sonar_port import SonarPort
from sim_bridge.observations import RobotObservation
from sim_bridge.robot_model import RobotModel
from sim_bridge.ros_conversions import ground_truth_msg, odometry_msg, scan_msg, velocity_from_msg


class RobotPort:
    """Publishes one robot's observations and keeps its newest command.

    Args:
        node: The node.
        name: Name of the robot: its namespace below the node's, "" for none.
        model: Its model.
        is_stamped: True for TwistStamped on `cmd_vel`.
        is_one_sonar_topic: True for all sonars on `sonar`, False for one topic each.
        tf: Where moving transforms go.
        tf_static: Where the sensor places go.
        frame_prefix: Stands before the names of its frames.
    """

    def __init__(
        self,
        node: FloornavNode,
        name: str,
        model: RobotModel,
        *,
        is_stamped: bool,
        is_one_sonar_topic: bool,
        tf: TransformBroadcaster,
        tf_static: StaticTransformBroadcaster,
        frame_prefix: str,
    ) -> None:
        """Create the topics, send the description and the sensor places."""
        self._node, self._model, self._tf = node, model, tf
        topic = f"{name}/" if name else ""
        self._topic = topic
        self._prefix = frame_prefix
        self._odom = self._prefix + node.frames.odom_frame
        self._base = self._prefix + node.frames.base_frame
        self._scan_pub = create_publisher(node, LaserScan, f"{topic}scan", RELIABLE_QOS)
        self._sonar = SonarPort(node, topic, self._prefix, model, is_one_topic=is_one_sonar_topic)
        self._cameras = CameraPort(node, topic, self._prefix, model)
        self._odom_pub = create_publisher(node, Odometry, f"{topic}odom", RELIABLE_QOS)
        self._truth_pub = create_publisher(
            node, Odometry, f"{topic}ground_truth/odom", RELIABLE_QOS
        )
        self._touch_pub = create_publisher(node, Bool, f"{topic}ground_truth/contact", LATCHED_QOS)
        command = TwistStamped if is_stamped else Twist
        create_subscription(node, command, f"{topic}cmd_vel", self._on_command, RELIABLE_QOS)
        self._urdf_pub = create_publisher(node, String, f"{topic}robot_description", LATCHED_QOS)
        self._urdf_pub.publish(String(data=model.urdf))
        for link, T_base_link in model.mounts.items():
            tf_static.send(self._base, self._prefix + link, 0, Transform3(T_base_link))
        self._command: Velocity | None = None
        self._was_touching: bool | None = None
        self._limited = ""

    def take_command(self) -> Velocity | None:
        """Return the command that came since the last call, if one did."""
        command, self._command = self._command, None
        return command

    def is_watched(self, camera: str) -> bool:
        """Tell whether anybody subscribes to what a camera sees."""
        return self._cameras.is_watched(camera)

    def publish(self, stamp_ns: int, seen: RobotObservation) -> None:
        """Publish one step: the transform first, so that the scan finds it there."""
        config = self._model.config
        if seen.refused:
            self._node.get_logger().warning(
                f"{self._topic}cmd_vel refused, the robot stops: {seen.refused}",
                throttle_duration_sec=2.0,
            )
        if seen.odometry is not None:
            T_odom_base = Transform3.from_se2(seen.odometry.pose)
            self._tf.send(self._odom, self._base, stamp_ns, T_odom_base)
            msg = odometry_msg(seen.odometry, config.odometry, stamp_ns, self._odom, self._base)
            self._odom_pub.publish(msg)
            self._truth_pub.publish(ground_truth_msg(seen.ground_truth, stamp_ns, self._base))
        if seen.scan is not None and config.laser is not None:
            frame = self._prefix + config.laser.frame
            self._scan_pub.publish(scan_msg(seen.scan, config.laser, stamp_ns, frame))
        if seen.sonar is not None:
            self._sonar.publish(stamp_ns, seen.sonar)
        self._cameras.publish(stamp_ns, seen)
        if seen.ground_truth.is_touching != self._was_touching:
            self._was_touching = seen.ground_truth.is_touching
            self._touch_pub.publish(Bool(data=self._was_touching))

    def _on_command(self, msg: Any) -> None:
        self._command = velocity_from_msg(msg)
        drive = self._model.config.drive
        limited = "" if refusal(drive, self._command) else limitation(drive, self._command)
        if limited and limited != self._limited:
            self._limited = limited
            text = f"{self._topic}cmd_vel: {limited}"
            self._node.get_logger().warning(text, throttle_duration_sec=2.0)
