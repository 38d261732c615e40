"""What any answer to a scan costs here: a node that sends a constant command for each scan."""

from __future__ import annotations

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from floornav_common.ros.main import make_executor
from floornav_common.ros.qos import RELIABLE_QOS, SENSOR_QOS


def main() -> None:
    """Run until told to end."""
    rclpy.init()
    node, executor = Node("graph_floor"), make_executor()
    commands = node.create_publisher(TwistStamped, "cmd_vel", RELIABLE_QOS)

    def answer(_: LaserScan) -> None:
        msg = TwistStamped()
        msg.header.stamp = node.get_clock().now().to_msg()
        commands.publish(msg)

    node.create_subscription(LaserScan, "scan", answer, SENSOR_QOS)
    executor.add_node(node)
    print("ready", flush=True)
    while rclpy.ok():
        executor.spin_once(timeout_sec=0.5)


if __name__ == "__main__":
    main()
