"""The topics of each robot in a team, put into its inbox.

Absolute names are built from the team's namespaces here, in `team_mounts`, in `team_clocks` and in
`team_outputs`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry

from floornav_common.ros.messages import pose_to_se2, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import (
    RELIABLE_QOS,
    SENSOR_QOS,
    create_subscription,
    publisher_names,
)
from floornav_common.time_watch import Throttle
from multi_localizer.nodes.team_mounts import CameraMounts
from multi_localizer.robot_inbox import ROBOTS, RobotInbox
from multi_localizer.ros_conversions import bearings_from_msg, estimate_from_msg
from multi_localizer.team_inbox import TeamInbox

_WARN_PERIOD_NS = 10_000_000_000


class TeamInputs:
    """Subscribes to what the robots of a team send.

    Args:
        node: The node.
        inbox: Where it goes.
        kinds: Classes of bearings besides those to robots.
        pose_topic: The robots' own localization, below their namespaces.
        mounts: Where cameras sit.
        on_bearings: Called after new bearings to robots came.
    """

    def __init__(
        self,
        node: FloornavNode,
        inbox: TeamInbox,
        kinds: Sequence[str],
        pose_topic: str,
        mounts: CameraMounts,
        on_bearings: Callable[[], None],
    ) -> None:
        """Subscribe."""
        self._node, self._inbox, self._mounts = node, inbox, mounts
        self._on_new = on_bearings
        self._warnings = {name: Throttle(_WARN_PERIOD_NS) for name in inbox.robots}
        for name, robot in inbox.robots.items():
            for kind in (ROBOTS, *kinds):
                self._subscribe(PoseArray, f"{name}/bearings/{kind}", self._bearings(robot, kind))
            topic = f"{name}/{pose_topic.strip('/')}"
            self._subscribe(PoseWithCovarianceStamped, topic, self._pose(robot))
            self._subscribe(Odometry, f"{name}/odom", self._odometry(robot), SENSOR_QOS)
        node.time.on_look(self._look)

    def _subscribe(
        self, kind: type, topic: str, callback: Callable[[Any], None], qos: Any = RELIABLE_QOS
    ) -> None:
        create_subscription(self._node, kind, f"/{topic}", callback, qos)

    def _look(self) -> None:
        """Two who send bearings for one robot are two robots of one name: neither is believed."""
        for name in self._inbox.robots:
            topic = f"/{name}/bearings/{ROBOTS}"
            num = self._node.count_publishers(topic)
            text = ""
            if num > 1:
                names = " and ".join(publisher_names(self._node, topic))
                text = f"{num} nodes publish {topic}, {names}: two robots of one name?"
            self._inbox.robots[name].problem = text

    def _now_ns(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _bearings(self, robot: RobotInbox, kind: str) -> Callable[[Any], None]:
        def take(msg: Any) -> None:
            now_ns, stamp_ns = self._now_ns(), stamp_to_ns(msg.header.stamp)
            robot.clock.take_stamp(stamp_ns, now_ns)
            mount = self._mounts.find(robot.name, msg.header.frame_id.lstrip("/"))
            if mount is None:
                robot.mount_problem = self._mounts.missing_text(msg.header.frame_id, robot.name)
            elif kind == ROBOTS:
                robot.mount = mount
            is_new = robot.take_bearings(kind, stamp_ns, bearings_from_msg(msg), now_ns)
            if is_new and kind == ROBOTS:
                self._inbox.note_bearings(robot.name, self._node.time.read_ns())
            if is_new:
                self._on_new()

        return take

    def _pose(self, robot: RobotInbox) -> Callable[[Any], None]:
        def take(msg: Any) -> None:
            frame = msg.header.frame_id.rpartition("/")[2]
            wanted = self._node.frames.map_frame
            try:
                if frame != wanted:
                    raise ValueError(f"its pose is in '{msg.header.frame_id}', not in '{wanted}'")
                estimate, stamp_ns = estimate_from_msg(msg), stamp_to_ns(msg.header.stamp)
                self._inbox.take_pose(robot.name, stamp_ns, estimate, self._now_ns())
            except ValueError as error:
                robot.counts["void poses"] += 1
                self._warn(robot, str(error))

        return take

    def _odometry(self, robot: RobotInbox) -> Callable[[Any], None]:
        def take(msg: Any) -> None:
            try:
                pose = pose_to_se2(msg.pose.pose)
            except ValueError as error:
                self._warn(robot, f"its odometry is void: {error}")
                return
            robot.take_odometry(stamp_to_ns(msg.header.stamp), pose, self._now_ns())

        return take

    def _warn(self, robot: RobotInbox, text: str) -> None:
        if self._warnings[robot.name].is_due(self._node.time.steady_ns()):
            self._node.get_logger().warning(f"{robot.name}: {text}")
