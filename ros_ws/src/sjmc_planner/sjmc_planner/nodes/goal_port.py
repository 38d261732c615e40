"""Where the planner is told to go: the topic `path` or the topic `goal_pose`."""

from __future__ import annotations

import importlib.util
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from floornav_common.ros.messages import pose_to_se2
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, create_subscription
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.path_target import PathTarget
from sjmc_planner.ros_conversions import path_points


class GoalPort:
    """The goal in force.

    Args:
        node: The node.
        config: Which source, and how far ahead to look on a path.

    Attributes:
        target: What to follow; None without a goal.
        frame: Frame it is given in.

    Raises:
        ParameterError: If `goal_source` asks for what is not there.
    """

    def __init__(self, node: FloornavNode, config: LocalPlannerConfig) -> None:
        self._node, self._config = node, config
        self.target: PathTarget | None = None
        self.frame = ""
        if config.goal_source == "follow_path":
            raise ParameterError(_why_no_action(node.get_fully_qualified_name()))
        if config.goal_source == "path":
            create_subscription(node, Path, "path", self._on_path, LATCHED_QOS)
        else:
            create_subscription(node, PoseStamped, "goal_pose", self._on_goal, RELIABLE_QOS)

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take another lookahead, from the next goal on."""
        self._config = config

    def clear(self) -> None:
        """Forget the goal."""
        self.target = None

    def _on_path(self, msg: Any) -> None:
        frames = {p.header.frame_id for p in msg.poses} - {"", msg.header.frame_id}
        if not msg.poses:
            self.clear()
            self._node.get_logger().info("an empty path: the goal is canceled")
        elif frames:
            self._refuse(f"path in '{msg.header.frame_id}' has poses in {sorted(frames)}")
        else:
            self._take(lambda: path_points(msg), msg.header.frame_id)

    def _on_goal(self, msg: Any) -> None:
        def points() -> Any:
            pose = pose_to_se2(msg.pose)
            return pose.as_array()[None, :2]

        self._take(points, msg.header.frame_id)

    def _take(self, points: Any, frame: str) -> None:
        try:
            if not frame.strip("/"):
                raise ValueError("its frame_id is empty")
            self.target = PathTarget(points(), self._config.lookahead_m)
            self.frame = frame
        except ValueError as error:
            self._refuse(str(error))

    def _refuse(self, text: str) -> None:
        """Say what is wrong; what was told before does not count any more either."""
        self.clear()
        self._node.get_logger().error(f"goal refused: {text}")


def _why_no_action(name: str) -> str:
    if importlib.util.find_spec("nav2_msgs") is None:
        why = "needs nav2_msgs, which is not installed"
    else:
        why = "is not offered by this version"
    return f"{name}: parameter goal_source: follow_path {why}; use path or goal_pose"
