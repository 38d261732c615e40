"""Publish one ultrasonic ranger on the robot's left, 20 cm from its middle."""

# ruff: noqa: TID251 - a node by itself, in no package
import contextlib
import math

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Range
from tf2_msgs.msg import TFMessage

FRAME, YAW = "sonar_left", math.pi / 2
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def read_m() -> float:
    """Return the distance of the echo, inf without one. Replace this by your hardware."""
    return 0.84


class SonarDriver(Node):
    """Sends where the sonar sits once, and a range ten times a second."""

    def __init__(self):
        super().__init__("sonar_driver")
        self.ranges = self.create_publisher(Range, "sonar", 10)
        self.transforms = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        placed = TransformStamped()
        placed.header.frame_id, placed.child_frame_id = "base_link", FRAME
        placed.header.stamp = self.get_clock().now().to_msg()
        placed.transform.translation.y, placed.transform.translation.z = 0.2, 0.25
        placed.transform.rotation.z = math.sin(YAW / 2)
        placed.transform.rotation.w = math.cos(YAW / 2)
        self.transforms.publish(TFMessage(transforms=[placed]))
        self.create_timer(0.1, self.measure)

    def measure(self):
        """Publish one reading, stamped now."""
        message = Range(radiation_type=Range.ULTRASOUND)
        message.header.frame_id = FRAME
        message.header.stamp = self.get_clock().now().to_msg()
        message.field_of_view = 0.35  # full angle of the cone
        message.min_range, message.max_range = 0.05, 4.0
        message.range = read_m()
        self.ranges.publish(message)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(SonarDriver())
