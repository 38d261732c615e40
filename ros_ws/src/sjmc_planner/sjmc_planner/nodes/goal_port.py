"""Where the planner is told to go: the topic `path`, the topic `goal_pose`, or Nav2's action."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from floornav_common.ros.messages import pose_to_se2
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, create_subscription
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.goal_progress import goal_name
from sjmc_planner.nodes.follow_path_port import FollowPathPort
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
        self._action: FollowPathPort | None = None
        if config.goal_source == "follow_path":
            self._action = FollowPathPort(node, config, self._on_path, self.clear)
        elif config.goal_source == "path":
            create_subscription(node, Path, "path", self._on_path, LATCHED_QOS)
        else:
            create_subscription(node, PoseStamped, "goal_pose", self._on_goal, RELIABLE_QOS)

    @property
    def name(self) -> str:
        """Where the goal is, as `goal_name` gives it; "" without one."""
        return "" if self.target is None else goal_name(self.frame, *self.target.end)

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take another lookahead, from the next goal on."""
        self._config = config
        if self._action is not None:
            self._action.set_config(config)

    def note(self, state: str, reason: str, left: float | None, moved: SE2, speed: float) -> None:
        """Tell who sent the goal how it goes, if that one wants to know; see FollowPathPort."""
        if self._action is not None:
            self._action.note(state, reason, left, moved, speed)

    def clear(self) -> None:
        """Forget the goal."""
        self.target = None

    def _on_path(self, msg: Any) -> str:
        """Take a path; return "" or what is wrong with it."""
        frames = {p.header.frame_id for p in msg.poses} - {"", msg.header.frame_id}
        if not msg.poses:
            if self.target is not None:
                self._node.get_logger().info("an empty path: the goal is canceled")
            self.clear()
            return "the path is empty"
        if frames:
            fault = f"path in '{msg.header.frame_id}' has poses in {sorted(frames)}"
            return self._refuse(fault)
        return self._take(lambda: path_points(msg), msg.header.frame_id)

    def _on_goal(self, msg: Any) -> None:
        def points() -> Any:
            pose = pose_to_se2(msg.pose)
            return pose.as_array()[None, :2]

        self._take(points, msg.header.frame_id)

    def _take(self, points: Any, frame: str) -> str:
        try:
            if not frame.strip("/"):
                raise ValueError("its frame_id is empty")
            self.target = PathTarget(points(), self._config.lookahead_m)
            self.frame = frame
        except ValueError as error:
            return self._refuse(str(error))
        return ""

    def _refuse(self, text: str) -> str:
        """Say what is wrong; what was told before does not count any more either."""
        self.clear()
        self._node.get_logger().error(f"goal refused: {text}")
        return text
