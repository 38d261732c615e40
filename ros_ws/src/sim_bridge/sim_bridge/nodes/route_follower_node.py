"""Drives a robot along a fixed route and ends when it is there.

In: `odom` (Odometry), `pose` (PoseWithCovarianceStamped of a mapper or localizer).
Out: `cmd_vel` (Twist).

It steers by the mapper's pose, carried on by the odometry since then (or by odometry alone with
`steer_by: odom`), and never sees ground truth. Without a fresh pose it stops. It does not look at
the scan: it is a script for the demo, not a planner. Exit code 0 = the end of the route.
"""

from __future__ import annotations

import sys
from collections import OrderedDict

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import pose_to_se2, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher, create_subscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from sim_bridge.config import RouteConfig
from sim_bridge.drive import STOP, Velocity
from sim_bridge.route import RouteFollower

_KEPT_ODOMETRY = 500


class RouteFollowerNode(FloornavNode):
    """Feeds poses to a `RouteFollower`."""

    def __init__(self) -> None:
        """Wait for the first pose."""
        super().__init__("route_follower")
        self._config = declare_config(self, RouteConfig)
        self._follower = RouteFollower(self._config)
        self._T_odom_base: OrderedDict[int, SE2] = OrderedDict()
        self._T_map_odom = SE2.identity() if self._config.steer_by == "odom" else None
        self._corrected_ns = 0
        self._cmd_pub = create_publisher(self, Twist, "cmd_vel", RELIABLE_QOS)
        poses = create_subscription(
            self, PoseWithCovarianceStamped, "pose", self._on_pose, RELIABLE_QOS
        )
        odometry = create_subscription(self, Odometry, "odom", self._on_odom, RELIABLE_QOS)
        self._poses = Watchdog(self, poses.topic_name, self._config.pose_timeout_s)
        self._odometry = Watchdog(self, odometry.topic_name, self._config.pose_timeout_s)
        self.ready()

    def _on_pose(self, msg: PoseWithCovarianceStamped) -> None:
        self._poses.feed()
        stamp_ns = stamp_to_ns(msg.header.stamp)
        T_odom_base = self._T_odom_base.get(stamp_ns)
        if self._config.steer_by == "pose" and T_odom_base is not None:
            self._T_map_odom = pose_to_se2(msg.pose.pose) @ T_odom_base.inverse()
            self._corrected_ns = stamp_ns

    def _on_odom(self, msg: Odometry) -> None:
        self._odometry.feed()
        stamp_ns, T_odom_base = stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)
        self._T_odom_base[stamp_ns] = T_odom_base
        if len(self._T_odom_base) > _KEPT_ODOMETRY:
            self._T_odom_base.popitem(last=False)
        if not self._has_pose(stamp_ns):
            self._send(STOP)
            return
        assert self._T_map_odom is not None
        command = self._follower.step(self._T_map_odom @ T_odom_base)
        self._send(STOP if command is None else command)
        if command is None:
            self.get_logger().info("end of the route")
            rclpy.try_shutdown()

    def _has_pose(self, stamp_ns: int) -> bool:
        if self._T_map_odom is None:
            self.get_logger().warning("no pose yet: waiting", throttle_duration_sec=5.0)
            return False
        age_s = (stamp_ns - self._corrected_ns) * 1e-9
        if self._config.steer_by == "pose" and age_s > self._config.pose_timeout_s:
            self.get_logger().warning(
                f"pose is {age_s:.1f} s old: stopped", throttle_duration_sec=2.0
            )
            return False
        return True

    def _send(self, velocity: Velocity) -> None:
        msg = Twist()
        msg.linear.x, msg.angular.z = velocity.speed, velocity.yaw_rate
        self._cmd_pub.publish(msg)


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(RouteFollowerNode, args)


if __name__ == "__main__":
    sys.exit(main())
