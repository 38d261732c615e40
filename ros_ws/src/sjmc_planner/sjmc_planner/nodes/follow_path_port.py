"""Nav2's action FollowPath: the planner in the place of `controller_server`."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.follow_progress import THERE, FollowProgress, Outcome
from sjmc_planner.planning import REACHED

_STANDS = 0.05  # m/s
_CANCELED, _PREEMPTED = "canceled", "preempted"


class FollowPathPort:
    """Takes goals of the action, one at a time: a new one takes the place of the old one.

    Args:
        node: The node.
        config: When a path is given up.
        take: Takes a path's message; returns "" or what is wrong with it.
        clear: Forgets the path.

    Raises:
        ParameterError: If nav2_msgs is not installed.
    """

    def __init__(
        self, node: FloornavNode, config: LocalPlannerConfig, take: Callable[[Any], str],
        clear: Callable[[], None],
    ) -> None:  # fmt: skip
        self._node, self._config, self._take, self._clear = node, config, take, clear
        self._action = _action_type(node.get_fully_qualified_name())
        self._goal: Any = None
        self._end: Future = Future()
        self._progress = FollowProgress(config.follow)
        self._feedback_due_s = 0.0
        self._server = ActionServer(
            node, self._action, "follow_path", self._follow,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )  # fmt: skip

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take other limits, from the next path on."""
        self._config = config

    def note(self, state: str, reason: str, left: float | None, moved: SE2, speed: float) -> None:
        """Take how it goes; once a control period.

        Args:
            state: As on `planner/state`.
            reason: Beside it.
            left: Distance left, m; None if not known.
            moved: The robot's motion since the last call.
            speed: Of the robot, m/s.
        """
        if self._goal is None:
            return
        period = self._config.control_period_s
        if self._goal.is_cancel_requested:
            self._finish(Outcome(_CANCELED))
            return
        if state == REACHED and speed > _STANDS:
            return  # it is to stand there
        outcome = self._progress.update(state, reason, moved, period)
        if outcome is not None:
            self._finish(outcome)
            return
        self._feedback_due_s -= period
        if left is not None and self._feedback_due_s <= 0.0:
            self._feedback_due_s = self._config.follow.feedback_period_s
            feedback = self._action.Feedback(distance_to_goal=float(left), speed=float(speed))
            self._goal.publish_feedback(feedback)

    def _on_accepted(self, goal: Any) -> None:
        """Take a goal; one in force goes on being watched as before, for it is the same drive."""
        if self._goal is None:
            self._progress = FollowProgress(self._config.follow)
        else:
            self._end.set_result(Outcome(_PREEMPTED, "another path took its place"))
        self._goal, self._end = goal, Future()
        self._feedback_due_s = 0.0
        fault = self._take(goal.request.path)
        goal.execute()
        if fault:
            self._finish(Outcome("INVALID_PATH", fault))

    def _finish(self, outcome: Outcome) -> None:
        self._goal = None
        self._clear()
        self._end.set_result(outcome)

    async def _follow(self, goal: Any) -> Any:
        """Wait for the end and tell the client."""
        outcome = await self._end
        result = self._action.Result()
        if outcome.code == THERE:
            goal.succeed()
        elif outcome.code == _CANCELED:
            goal.canceled()
        else:
            goal.abort()
            self._node.get_logger().warning(f"path given up: {outcome.code}: {outcome.text}")
        if outcome.code not in (THERE, _CANCELED, _PREEMPTED):
            result.error_code = getattr(result, outcome.code, result.UNKNOWN)
        if hasattr(result, "error_msg"):  # from Jazzy on
            result.error_msg = outcome.text
        return result


def _action_type(name: str) -> Any:
    if importlib.util.find_spec("nav2_msgs") is None:
        raise ParameterError(
            f"{name}: parameter goal_source: follow_path needs nav2_msgs, which is not installed; "
            "use path or goal_pose"
        )
    from nav2_msgs.action import FollowPath

    return FollowPath
