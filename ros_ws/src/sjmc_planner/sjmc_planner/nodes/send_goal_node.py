"""Sends a goal to a planner and says how it goes, until it is reached.

In: `planner/state` (DiagnosticStatus).
Out: `goal_pose` (PoseStamped, stamp 0: where the frame is now).

For who has no `ros2 topic pub`. It ends with 0 when the goal is reached, or, with `waits: false`,
when it is sent. Ending it earlier leaves the planner its goal.
"""

from __future__ import annotations

import sys

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import se2_to_pose
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher, create_subscription
from floornav_common.se2 import SE2
from sjmc_planner.config import SendGoalConfig
from sjmc_planner.goal_progress import GoalProgress

_PERIOD_S = 0.5
_NUM_SENDS = 3  # a publisher knows of its listener before that one hears it
_MOST_SENDS = 20  # to a planner that goes on saying that it has no goal
_SAY_PERIOD_S = 5.0


class SendGoalNode(FloornavNode):
    """Feeds what the planner says to a GoalProgress."""

    def __init__(self) -> None:
        """Wait for a planner."""
        super().__init__("send_goal")
        self._config = config = declare_config(self, SendGoalConfig)
        self._goal = PoseStamped(pose=se2_to_pose(SE2(config.x_m, config.y_m, config.yaw_rad)))
        self._goal.header.frame_id = config.frame
        self._progress = GoalProgress()
        self._num_sent = 0
        self._goal_pub = create_publisher(self, PoseStamped, "goal_pose", RELIABLE_QOS)
        create_subscription(self, DiagnosticStatus, "planner/state", self._on_state, RELIABLE_QOS)
        self.create_timer(_PERIOD_S, self._send, clock=self.time.steady_clock)
        self.ready()

    def _send(self) -> None:
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

    @property
    def _is_unheard(self) -> bool:
        """Whether the planner, that may not have been found yet, does not seem to have it."""
        is_asked = self._config.waits and self._num_sent < _MOST_SENDS
        return is_asked and self._progress.is_idle

    def _on_state(self, msg: DiagnosticStatus) -> None:
        if self._num_sent < _NUM_SENDS:
            return
        values = {v.key: v.value for v in msg.values}
        line = self._progress.update(values.get("state", ""), values.get("reason", ""))
        if line and not self._is_unheard:
            left = values.get("distance left (m)", "")
            self.get_logger().info(f"{line}, {left} m left" if left else line)
        if self._progress.is_reached and self._config.waits:
            rclpy.try_shutdown()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(SendGoalNode, args)


if __name__ == "__main__":
    sys.exit(main())
