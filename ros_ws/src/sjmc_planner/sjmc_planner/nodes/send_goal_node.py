"""Sends a goal to a planner and says how it goes, until it is reached.

In: `planner/state` (DiagnosticStatus), `/diagnostics` (part `path` of wavefront_planner).
Out: `goal_pose` (PoseStamped, stamp 0: where the frame is now).

For who has no `ros2 topic pub`. It ends with 0 when the goal is reached, or, with `waits: false`,
when it is sent; with 1 when there is no way to it for some seconds. Ending it earlier leaves the
planner its goal.
"""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped

from floornav_common.ros.main import EXIT_FAILED, EXIT_OK, run_node
from floornav_common.ros.messages import se2_to_pose
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher, create_subscription
from floornav_common.se2 import SE2
from sjmc_planner.config import SendGoalConfig
from sjmc_planner.goal_progress import GoalProgress, goal_name
from sjmc_planner.way_progress import WayProgress

_PERIOD_S = 0.5
_NUM_SENDS = 3  # a publisher knows of its listener before that one hears it
_MOST_SENDS = 20  # to a planner that goes on saying that it has no goal
_SAY_PERIOD_S = 5.0
_GIVE_UP_S = 5.0


class SendGoalNode(FloornavNode):
    """Feeds what the planners say to a GoalProgress and a WayProgress.

    Attributes:
        is_given_up: Whether there was no way for too long.
    """

    def __init__(self) -> None:
        """Wait for a planner."""
        super().__init__("send_goal")
        self._config = config = declare_config(self, SendGoalConfig)
        self._goal = PoseStamped(pose=se2_to_pose(SE2(config.x_m, config.y_m, config.yaw_rad)))
        self._goal.header.frame_id = config.frame
        self._progress = GoalProgress()
        self._way = WayProgress(goal_name(config.frame, config.x_m, config.y_m))
        self._num_sent, self._line, self.is_given_up = 0, "", False
        self._goal_pub = create_publisher(self, PoseStamped, "goal_pose", RELIABLE_QOS)
        create_subscription(self, DiagnosticStatus, "planner/state", self._on_state, RELIABLE_QOS)
        create_subscription(self, DiagnosticArray, "/diagnostics", self._on_parts, RELIABLE_QOS)
        self.create_timer(_PERIOD_S, self._look, clock=self.time.steady_clock)
        self.ready()

    def _look(self) -> None:
        """Send the goal, again while nobody seems to have it; end where no way leads to it."""
        if not self._goal_pub.get_subscription_count():
            self.get_logger().warning(
                f"nobody listens to {self._goal_pub.topic_name}: start wavefront_planner, or "
                "local_planner with goal_source:=goal_pose, in this ROS_DOMAIN_ID",
                throttle_duration_sec=_SAY_PERIOD_S,
            )
        elif self._num_sent < _NUM_SENDS or self._is_unheard:
            self._num_sent += 1
            self._goal_pub.publish(self._goal)
        elif not self._config.waits:
            rclpy.try_shutdown()
        elif self._way.no_way_s(self.time.steady_ns()) >= _GIVE_UP_S:
            self.get_logger().error(f"given up: no way for {_GIVE_UP_S:g} s")
            self.is_given_up = True
            rclpy.try_shutdown()

    @property
    def _is_unheard(self) -> bool:
        """Whether the planner, that may not have been found yet, does not seem to have it."""
        if not self._config.waits or self._num_sent >= _MOST_SENDS:
            return False
        return not self._way.has_goal if self._way.is_heard else self._progress.is_idle

    def _on_parts(self, msg: Any) -> None:
        """Take what the planner of ways in this namespace says."""
        if self._num_sent < _NUM_SENDS:
            return
        for status in msg.status:
            node, _, part = status.name.rpartition(": ")
            values = {v.key: v.value for v in status.values}
            namespace = node.rpartition("/")[0] or "/"
            if part == "path" and namespace == self.get_namespace() and "goal" in values:
                now_ns, end = self.time.steady_ns(), values.get("path ends at", "")
                line = self._way.update(status.message, values["goal"], end, now_ns)
                if line:
                    self.get_logger().warning(line)

    def _on_state(self, msg: Any) -> None:
        if self._num_sent < _NUM_SENDS:
            return
        values = {v.key: v.value for v in msg.values}
        state, target = values.get("state", ""), values.get("goal", "")
        line = self._progress.update(state, values.get("reason", ""), self._way.leads(target))
        left = values.get("distance left (m)", "")
        self._line = (f"{line}, {left} m left" if left else line) or self._line
        is_plain = self._progress.is_idle and (self._way.has_goal or self._is_unheard)
        if self._line and not is_plain:
            self.get_logger().info(self._line)
            self._line = ""
        if self._progress.is_reached and self._config.waits:
            rclpy.try_shutdown()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    nodes: list[SendGoalNode] = []

    def send_goal() -> SendGoalNode:
        nodes.append(SendGoalNode())
        return nodes[0]

    code = run_node(send_goal, args)
    is_given_up = any(node.is_given_up for node in nodes)
    return EXIT_FAILED if code == EXIT_OK and is_given_up else code


if __name__ == "__main__":
    sys.exit(main())
