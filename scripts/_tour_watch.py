"""What the demo hears of a world, robot by robot, and its commands: one node of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import Image, LaserScan, Range
from std_msgs.msg import Bool

from _tour_drivers import Driver
from floornav_common.readings import RangeReading
from floornav_common.ros.messages import (
    image_to_array,
    pose_to_se2,
    poses_from_msg,
    range_from_msg,
    scan_from_msg,
    stamp_to_ns,
)
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge.robot_model import RobotModel


@dataclass
class RobotHeard:
    """All of one robot so far.

    Attributes:
        truth: (stamp, true pose), one every 20 ms.
        scan: The newest (stamp, scan).
        sonar: The newest (stamp, reading) by frame, without prefix.
        images: The newest image, RGB, by topic.
        counts: Messages by topic.
        has_touched: True once it touched something.
    """

    truth: list[tuple[int, SE2]] = field(default_factory=list)
    scan: tuple[int, Scan] | None = None
    sonar: dict[str, tuple[int, RangeReading]] = field(default_factory=dict)
    images: dict[str, np.ndarray] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    has_touched: bool = False

    def pose_at(self, stamp_ns: int) -> SE2 | None:
        """Return the true pose nearest to a stamp."""
        if not self.truth:
            return None
        return min(reversed(self.truth[-200:]), key=lambda item: abs(item[0] - stamp_ns))[1]


class TourWatch(Node):
    """Hears everything and drives every robot.

    Args:
        models: The robots by name.
        drivers: What steers them.

    Attributes:
        robots: What was heard of each.
        people: (stamp, true poses) so far.
    """

    def __init__(self, models: Mapping[str, RobotModel], drivers: Mapping[str, Driver]) -> None:
        super().__init__("demo_watch")
        self.robots = {name: RobotHeard() for name in models}
        self.people: list[tuple[int, list[SE2]]] = []
        self._drivers = drivers
        self._commands: dict[str, Any] = {}
        deep = RELIABLE_QOS.__class__(depth=100, reliability=RELIABLE_QOS.reliability)
        for name, model in models.items():
            self._listen(name, model, deep)
        self.create_subscription(PoseArray, "ground_truth/people", self._on_people, deep)

    @property
    def sim_s(self) -> float:
        """Simulated time so far."""
        ends = [heard.truth[-1][0] for heard in self.robots.values() if heard.truth]
        return max(ends, default=0) * 1e-9

    def _listen(self, name: str, model: RobotModel, qos: Any) -> None:
        below, config = f"{name}/" if name else "", model.config
        self._commands[name] = self.create_publisher(Twist, f"{below}cmd_vel", RELIABLE_QOS)

        def hear(kind: type, topic: str, what: Any, profile: Any = qos) -> None:
            self.create_subscription(kind, below + topic, partial(what, name), profile)

        hear(Odometry, "ground_truth/odom", self._on_truth)
        hear(Bool, "ground_truth/contact", self._on_touch, LATCHED_QOS)
        if config.laser is not None:
            hear(LaserScan, "scan", self._on_scan)
        if config.sonar is not None:
            hear(Range, "sonar", self._on_sonar)
        topics = [] if config.omni is None else ["omni/image_raw"]
        for pair in () if config.stereo is None else config.stereo.pairs:
            topics += [f"stereo/{pair}/{side}/image_rect" for side in ("left", "right")]
        for topic in topics:
            hear(Image, topic, partial(self._on_image, topic))

    def _on_truth(self, name: str, msg: Any) -> None:
        heard, pose = self.robots[name], pose_to_se2(msg.pose.pose)
        heard.truth.append((stamp_to_ns(msg.header.stamp), pose))
        command = self._drivers[name].command(pose, heard.scan[1] if heard.scan else None)
        twist = Twist()
        twist.linear.x, twist.angular.z = command.speed, command.yaw_rate
        self._commands[name].publish(twist)

    def _on_touch(self, name: str, msg: Any) -> None:
        self.robots[name].has_touched |= msg.data

    def _on_scan(self, name: str, msg: Any) -> None:
        self.robots[name].scan = (stamp_to_ns(msg.header.stamp), scan_from_msg(msg))
        self._count(name, "scan")

    def _on_sonar(self, name: str, msg: Any) -> None:
        frame = msg.header.frame_id.removeprefix(f"{name}/" if name else "")
        self.robots[name].sonar[frame] = (stamp_to_ns(msg.header.stamp), range_from_msg(msg))
        self._count(name, "sonar")

    def _on_image(self, topic: str, name: str, msg: Any) -> None:
        self.robots[name].images[topic] = image_to_array(msg).copy()
        self._count(name, topic)

    def _on_people(self, msg: Any) -> None:
        self.people.append((stamp_to_ns(msg.header.stamp), list(poses_from_msg(msg))))

    def _count(self, name: str, topic: str) -> None:
        counts = self.robots[name].counts
        counts[topic] = counts.get(topic, 0) + 1
