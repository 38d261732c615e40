"""Where the robots of a team are, from the directions in which they see each other.

In, of each robot in `team`: `/<namespace>/bearings/robots`, `/<namespace>/bearings/<class>` of
landmarks and other things (PoseArray), `/<namespace>/pose` (PoseWithCovarianceStamped),
`/<namespace>/odom` (optional), `/<namespace>/tf_static`, `/<namespace>/team/clock`; `/tf_static`.
Out: `team_pose` of this robot (or `/<namespace>/team_pose` of all), `team/poses` (PoseArray in the
order of `team`, NaN where not known), `team/markers`, `objects` (PoseArray), `team/clock`; TF
map->odom with `publish_tf`.
"""

from __future__ import annotations

import sys
import time

from floornav_common.ros.main import run_node
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError, declare_config
from multi_localizer.landmarks import load_landmarks
from multi_localizer.nodes.team_clocks import TeamClocks
from multi_localizer.nodes.team_inputs import TeamInputs
from multi_localizer.nodes.team_mounts import CameraMounts
from multi_localizer.nodes.team_outputs import TeamOutputs
from multi_localizer.nodes.team_reports import TeamReports
from multi_localizer.nodes.team_watch import TeamWatch
from multi_localizer.robot_inbox import Classes
from multi_localizer.team_answers import TeamAnswers
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_inbox import TeamInbox
from multi_localizer.team_node_config import TeamNodeConfig, TeamTimingConfig
from multi_localizer.team_warm_up import warm_up

_LOOK_S = 0.03


class TeamLocalizerNode(FloornavNode):
    """Collects what the team sees, solves, and publishes."""

    def __init__(self) -> None:
        """Declare, subscribe to the whole team, compile, and say ready."""
        super().__init__("team_localizer")
        config = declare_config(self, TeamNodeConfig, on_change=self._set_config)
        self._timing = declare_config(self, TeamTimingConfig, on_change=self._set_timing)
        self._solver = declare_config(self, TeamConfig, on_change=self._set_solver)
        self._config = config
        own = self._own_name(config)
        try:
            landmarks = load_landmarks(config.landmarks) if config.landmarks else {}
        except (ValueError, OSError) as error:
            raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error
        classes = Classes(frozenset(landmarks), frozenset(config.object_classes) - landmarks.keys())
        self._inbox = TeamInbox(config.team, own, self._timing, classes)
        self._answers = TeamAnswers(self._inbox, landmarks, self._solver)
        self._configure()
        self._outputs = TeamOutputs(
            self, config.team, own, config.publish_for == "all", config.publish_tf
        )
        self._reports = TeamReports(self, self._inbox, own, lambda: self._timing)
        self._mounts = CameraMounts(self, config.team, own)
        kinds = sorted(classes.landmarks | classes.objects)
        self._inputs = TeamInputs(
            self, self._inbox, kinds, config.pose_topic, self._mounts, self._look
        )
        if own:
            others = {n: r.clock for n, r in self._inbox.robots.items() if n != own}
            self._clocks = TeamClocks(self, own, others)
        self._watch = TeamWatch(self, self._inbox, self._clocks.lists if own else {})
        self.time.on_restart(self._forget)
        self._timer = self.create_timer(_LOOK_S, self._look, clock=self.time.steady_clock)
        self.ready(lambda: warm_up(self._solver))

    def _own_name(self, config: TeamNodeConfig) -> str:
        """Return this robot's name in the team, by the namespace of this node."""
        name, namespace = self.get_fully_qualified_name(), self.get_namespace().strip("/")
        if not config.team:
            raise ParameterError(f"{name}: parameter team must name the robots, such as [r1, r2]")
        if namespace in config.team:
            return namespace
        if config.publish_for == "own":
            raise ParameterError(
                f"{name}: namespace '{namespace}' is not in team {list(config.team)}; start the "
                "node with -r __ns:=/NAME, or with -p publish_for:=all"
            )
        return ""

    def _look(self) -> None:
        passed_ns = self.time.read_ns()
        moment = self._inbox.take_due(passed_ns)
        if moment is None:
            self._outputs.look_at_tf()
            if not self._reports.is_fresh(passed_ns):
                self._outputs.stop_tf()
            return
        started = time.perf_counter()
        answer = self._answers.solve(moment)
        self._reports.take(answer, passed_ns, 1e3 * (time.perf_counter() - started))
        self._outputs.publish(answer)

    def _forget(self) -> None:
        self._inbox.clear()
        self._answers.forget()
        self._reports.forget()
        self._outputs.stop_tf()

    def _set_config(self, config: TeamNodeConfig) -> None:
        self._config = config
        self._configure()

    def _configure(self) -> None:
        told, sd = self._config, self._solver.bearing_sd_rad
        over_time = TeamFilterConfig(bearing_sd_rad=sd, repeat_s=told.repeat_s)
        self._answers.poses_use_landmarks = told.poses_use_landmarks
        self._answers.configure(self._solver, over_time if told.over_time else None)

    def _set_timing(self, timing: TeamTimingConfig) -> None:
        self._timing = timing
        self._inbox.configure(timing)

    def _set_solver(self, solver: TeamConfig) -> None:
        self._solver = solver
        self._configure()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(TeamLocalizerNode, args)


if __name__ == "__main__":
    sys.exit(main())
