"""Drives to a goal around what the scan shows.

In: `scan` (LaserScan; remap it to `floor/free_space` for a floor camera), `odom` (Odometry: its
twist), `path` (Path), `goal_pose` (PoseStamped) or the action `follow_path` (nav2_msgs/FollowPath),
TF goal frame->base_link->sensors, `/diagnostics` (of localizers: whether another sends map->odom).
Where they are, `map/glass` (OccupancyGrid) and `sonar` (Range; `known.sonar_topics`): glass.
Out: `cmd_vel` (Twist; TwistStamped with enable_stamped_cmd_vel), `planner/state`
(DiagnosticStatus), `planner/markers` (MarkerArray).
Services: `~/enable` (SetBool: false stops the robot until true).
"""

from __future__ import annotations

import sys
from typing import Any

from std_srvs.srv import SetBool

from floornav_common.ros.main import run_node
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.methods import make_method
from sjmc_planner.nodes.command_port import CommandPort
from sjmc_planner.nodes.control_timer import ControlTimer
from sjmc_planner.nodes.goal_port import GoalPort
from sjmc_planner.nodes.input_missing import InputMissing
from sjmc_planner.nodes.planner_inputs import PlannerInputs
from sjmc_planner.nodes.planner_report import STOPPED, PlannerReport
from sjmc_planner.planning import REACHED, RobotState
from sjmc_planner.warm_up import compile_kernels

_PAUSE_NS = 1_000_000_000
_NO_MOTION = SE2(0.0, 0.0, 0.0)


class LocalPlannerNode(FloornavNode):
    """Asks a method for the next command, and stops the robot when it does not know enough."""

    def __init__(self) -> None:
        """Declare, subscribe, compile, and say ready."""
        super().__init__("local_planner")
        self._config = declare_config(self, LocalPlannerConfig, on_change=self._set_config)
        self._method = make_method(self._config)
        self._is_enabled = True
        self._decided_ns: int | None = None
        self._goals = GoalPort(self, self._config)
        timer = ControlTimer(self, self._config.control_period_s, self._control)
        self._inputs = PlannerInputs(self, self._config, timer.take_scan)
        self._commands = CommandPort(self, self._config)
        self._report = PlannerReport(self)
        self.transforms.on_restart(self._commands.halt)
        self.time.on_look(self._look)
        self.create_service(SetBool, "~/enable", self._on_enable)
        self.ready(compile_kernels)

    def _set_config(self, config: LocalPlannerConfig) -> None:
        self._config, self._method = config, make_method(config)
        for part in (self._goals, self._inputs, self._commands):
            part.set_config(config)

    def _look(self) -> None:
        """Stop while /clock stands still: no timer of simulated time comes then."""
        if self.time.is_stopped:
            self._stop("/clock stands still")

    def _control(self) -> None:
        """Send the command for now."""
        if not self._is_enabled:
            self._commands.rest()
            self._tell("disabled", "by ~/enable")
        elif self._goals.target is None:
            self._commands.rest()
            self._tell("idle", "no goal")
        elif not self.time.is_stopped:
            try:
                self._drive()
            except InputMissing as error:
                self._stop(str(error))

    def _drive(self) -> None:
        """Decide and send.

        Raises:
            InputMissing: If the robot does not know enough to move.
        """
        velocity, now_ns = self._inputs.velocity(), self.time.read_ns()
        dt = self._since_last(now_ns)
        moved = moved_by(velocity, dt)
        goal = self._goals.target.goal(self._inputs.pose(self._goals.frame, velocity))
        obstacles = self._inputs.obstacles(velocity, moved, dt)
        self._decided_ns = now_ns
        decision = self._method.decide(
            RobotState(velocity, self._commands.last, moved), obstacles, goal,
            has_debug=self._report.wants_markers,
        )  # fmt: skip
        self._tell(decision.state, decision.reason, goal.distance, moved, velocity.speed)
        if decision.debug is not None:
            self._report.draw(decision.debug)
        is_over = self._goals.target is None  # who sent the goal has just been told its end
        if is_over or (decision.state == REACHED and self._commands.last.is_still):
            self._commands.rest()
        else:
            self._commands.drive(decision.command)

    def _tell(
        self, state: str, reason: str, left: float | None = None, moved: SE2 = _NO_MOTION,
        speed: float = 0.0,
    ) -> None:  # fmt: skip
        """Say how it goes."""
        self._report.set(state, reason, left, self._goals.name)
        self._goals.note(state, reason, left, moved, speed)

    def _since_last(self, now_ns: int) -> float:
        """Return the time since the last decision, s; after a pause or a jump it starts anew."""
        last_ns = self._decided_ns
        if last_ns is None or not 0 <= now_ns - last_ns <= _PAUSE_NS:
            self._method = make_method(self._config)
            self._inputs.known.forget()
            return 0.0
        return (now_ns - last_ns) * 1e-9

    def destroy_node(self) -> None:
        """End with a zero on `cmd_vel`, also when it ends by an error; the context is there yet."""
        self._commands.end()
        super().destroy_node()

    def _stop(self, reason: str) -> None:
        if self._is_enabled and self._goals.target is not None:
            self._commands.halt()
            self._tell(STOPPED, reason)

    def _on_enable(self, request: Any, response: SetBool.Response) -> SetBool.Response:
        self._is_enabled = bool(request.data)
        if not self._is_enabled:
            self._commands.halt()
        response.success = True
        response.message = "enabled" if self._is_enabled else "disabled: the robot stands"
        return response


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(LocalPlannerNode, args)


if __name__ == "__main__":
    sys.exit(main())
