"""What the team's localizer says of itself: one part for the team, one for each robot."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.node import FloornavNode
from multi_localizer.clock_offsets import clock_problem
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.nodes.team_robot_report import clock_values, part_in_answer
from multi_localizer.team_answers import TeamAnswer
from multi_localizer.team_inbox import TeamInbox
from multi_localizer.team_node_config import TeamTimingConfig

FEWEST = 3
"""Robots that make a triangle."""
_SETTLED_S, _PERIOD_S = 2.0, 10.0


class TeamReports:
    """Adds the parts to the node's diagnostics.

    Args:
        node: The node.
        inbox: Of the team.
        own: Namespace of this robot; "" if it is none of them.
        timing: Current values.
    """

    def __init__(
        self,
        node: FloornavNode,
        inbox: TeamInbox,
        own: str,
        timing: Callable[[], TeamTimingConfig],
    ) -> None:
        """Add them."""
        self._node, self._inbox, self._own, self._timing = node, inbox, own, timing
        self._answer: TeamAnswer | None = None
        self._answered_ns = 0
        self._ms = 0.0
        node.diagnostics.add("team", self.team_status)
        self._logs = [StateLog(node, self.team_status, period_s=_PERIOD_S)]
        for name in inbox.robots:
            check = partial(self.robot_status, name)
            node.diagnostics.add(f"robot {name}", check)
            log = StateLog(node, check, name, settled_s=_SETTLED_S, period_s=_PERIOD_S)
            self._logs.append(log)

    def take(self, answer: TeamAnswer, passed_ns: int, ms: float) -> None:
        """Take the newest answer."""
        self._answer, self._answered_ns, self._ms = answer, passed_ns, ms

    def forget(self) -> None:
        """Start anew."""
        self._answer = None

    def is_fresh(self, passed_ns: int) -> bool:
        """Whether there is an answer that is not old."""
        old_ns = round(self._timing().robot_timeout_s * 1e9)
        return self._answer is not None and passed_ns - self._answered_ns <= old_ns

    def team_status(self) -> Status:
        """Return how the team as a whole is."""
        passed_ns = self._node.time.read_ns()
        answer, num = self._answer, len(self._inbox.robots)
        if answer is None or not self.is_fresh(passed_ns):
            text = "no robot's bearings arrive" if not self._inbox.leader(passed_ns) else "waiting"
            if self._own and not self._inbox.is_present(self._own, passed_ns):
                text += ", this robot's neither"
            return Status(STALE, text, {"robots": num})
        solution = answer.solution
        values = {
            "robots": num,
            "robots that told": len(answer.moment.sights),
            "robots located": len(answer.bases),
            "time of solving (ms)": f"{self._ms:.2f}",
            "largest correction of a bearing (deg)": f"{math.degrees(answer.most_change):.2f}",
            "objects located": len(solution.objects),
        }
        return Status(*self._verdict(answer), values)

    def _verdict(self, answer: TeamAnswer) -> tuple[bytes, str]:
        solution, moment = answer.solution, answer.moment
        doubts = [f"{name}: {why}" for name, why in moment.missing.items()]
        doubts += solution.notes
        if solution.unobservable:
            doubts.append(solution.unobservable)
        if len(moment.sights) < FEWEST:
            doubts.insert(0, f"{len(moment.sights)} robots tell, {FEWEST} make a triangle")
        if solution.problem or not answer.bases:
            return ERROR, "; ".join([solution.problem or "no robot located", *doubts])
        if self._own and self._own not in answer.bases:
            return ERROR, "; ".join(["this robot is not located", *doubts])
        located = f"{len(answer.bases)} of {len(self._inbox.robots)} robots located"
        return (WARN, "; ".join([located, *doubts])) if doubts else (OK, located)

    def robot_status(self, name: str) -> Status:
        """Return how one robot is, as seen from here."""
        robot, passed_ns = self._inbox.robots[name], self._node.time.read_ns()
        values: dict[str, object] = {k: robot.counts[k] for k in sorted(robot.counts)}
        clock = ""
        if name != self._own:
            values |= clock_values(robot)
            clock = clock_problem(robot.clock.offset, round(self._timing().max_skew_s * 1e9))
        if robot.problem:
            return Status(ERROR, robot.problem, values)
        if not self._inbox.is_present(name, passed_ns):
            return Status(STALE, "; ".join(filter(None, [self._silence(name), clock])), values)
        if robot.mount is None:
            return Status(WARN, robot.mount_problem, values)
        if self._answer is None:
            return Status(WARN, "; ".join(filter(None, ["no answer yet", clock])), values)
        level, text = part_in_answer(name, self._answer, values)
        if clock and clock not in text:
            level, text = max(level, WARN), f"{text}; {clock}"
        return Status(level, text, values)

    def _silence(self, name: str) -> str:
        is_known = self._inbox.robots[name].heard_ns is not None
        return f"no bearings on /{name}/bearings/robots" + (" any more" if is_known else "")
