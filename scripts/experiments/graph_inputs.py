"""A laser, a base and a goal for a planner in a process of its own: how late its answers are.

    python -m experiments.graph_inputs SECONDS

Prints milliseconds from the publishing of a scan to the first command that was decided after it
came, one a line. Scans of 1081 beams come at 40 Hz, odometry and its transform at 50 Hz, the
stamps are the real time of publishing, and the base does what it is told. A command bears the
time of its decision (`enable_stamped_cmd_vel`).
"""

from __future__ import annotations

import sys
import time

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from floornav_common.ros.main import make_executor
from floornav_common.ros.messages import scan_to_msg, se2_to_pose, stamp_to_ns
from floornav_common.ros.qos import RELIABLE_QOS, SENSOR_QOS
from floornav_common.scan import Scan
from floornav_common.se2 import SE2

SCAN_S, ODOM_S, SETTLE_S = 0.025, 0.02, 2.0
NUM_BEAMS, FIELD_RAD = 1081, 4.71
"""A Hokuyo UTM-30LX's."""


class Inputs(Node):
    """Publishes what a planner hears, and takes the time of its commands."""

    def __init__(self) -> None:
        super().__init__("graph_inputs")
        self._scan_pub = self.create_publisher(LaserScan, "scan", SENSOR_QOS)
        self._odom_pub = self.create_publisher(Odometry, "odom", SENSOR_QOS)
        self._tf_pub = self.create_publisher(TFMessage, "/tf", RELIABLE_QOS)
        self._goal_pub = self.create_publisher(PoseStamped, "goal_pose", RELIABLE_QOS)
        self.create_subscription(TwistStamped, "cmd_vel", self._on_command, RELIABLE_QOS)
        self.create_timer(SCAN_S, self._send_scan)
        self.create_timer(ODOM_S, self._send_odometry)
        self.create_timer(1.0, self._send_goal)
        angles = np.linspace(-FIELD_RAD / 2, FIELD_RAD / 2, NUM_BEAMS)
        self._ranges = 6.0 + 2.0 * np.cos(3.0 * angles)  # a room, in front of which all is free
        self._rng = np.random.default_rng(0)
        self._pose, self._speed, self._yaw_rate = SE2.identity(), 0.0, 0.0
        self.sent: list[tuple[int, float]] = []
        self.heard: list[tuple[int, float]] = []

    def _send_scan(self) -> None:
        ranges = self._ranges + self._rng.normal(0.0, 0.01, NUM_BEAMS)
        scan = Scan(ranges, -FIELD_RAD / 2, FIELD_RAD / (NUM_BEAMS - 1), 0.05, 30.0)
        stamp = self.get_clock().now()
        header = Header(stamp=stamp.to_msg(), frame_id="base_link")
        self._scan_pub.publish(scan_to_msg(scan, header))
        self.sent.append((stamp.nanoseconds, time.monotonic()))

    def _send_odometry(self) -> None:
        turn = self._yaw_rate * ODOM_S
        self._pose = self._pose @ SE2(self._speed * ODOM_S, 0.0, turn)
        stamp = self.get_clock().now().to_msg()
        msg = Odometry()
        msg.header.stamp, msg.header.frame_id, msg.child_frame_id = stamp, "odom", "base_link"
        msg.pose.pose = se2_to_pose(self._pose)
        msg.twist.twist.linear.x, msg.twist.twist.angular.z = self._speed, self._yaw_rate
        self._odom_pub.publish(msg)
        transform = TransformStamped()
        transform.header, transform.child_frame_id = msg.header, "base_link"
        transform.transform.translation.x = self._pose.x
        transform.transform.translation.y = self._pose.y
        transform.transform.rotation = msg.pose.pose.orientation
        self._tf_pub.publish(TFMessage(transforms=[transform]))

    def _send_goal(self) -> None:
        ahead = self._pose @ SE2(3.0, 0.0, 0.0)  # never reached
        msg = PoseStamped()
        msg.header.frame_id, msg.pose = "odom", se2_to_pose(ahead)
        self._goal_pub.publish(msg)

    def _on_command(self, msg: TwistStamped) -> None:
        self._speed, self._yaw_rate = msg.twist.linear.x, msg.twist.angular.z
        self.heard.append((stamp_to_ns(msg.header.stamp), time.monotonic()))


def delays_ms(sent: list[tuple[int, float]], heard: list[tuple[int, float]]) -> np.ndarray:
    """Return how long each scan waited for the first command that was decided after it was sent.

    Args:
        sent: Stamp in ns and monotonic time in s of each scan, in order.
        heard: Time of the decision in ns and monotonic time in s of each command, in order.

    Returns:
        Milliseconds, of the scans that were answered.
    """
    decided = np.array([stamp for stamp, _ in heard])
    first = np.searchsorted(decided, [stamp for stamp, _ in sent])
    found = [heard[k][1] - wall for k, (_, wall) in zip(first, sent, strict=True) if k < len(heard)]
    return 1e3 * np.array(found)


def main() -> None:
    """Run for a while and print."""
    rclpy.init()
    node, executor = Inputs(), make_executor()
    executor.add_node(node)
    end = time.monotonic() + SETTLE_S + float(sys.argv[1])
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
        if time.monotonic() < end - float(sys.argv[1]):
            node.sent.clear()
    print("\n".join(f"{ms:.3f}" for ms in delays_ms(node.sent, node.heard)))
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
