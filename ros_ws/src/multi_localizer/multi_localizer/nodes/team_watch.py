"""Looks for misspelled teammates: robots that are not in the list, and lists that differ."""

from __future__ import annotations

from collections.abc import Mapping

from floornav_common.ros.diagnostics import OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.time_watch import Throttle
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.team_inbox import TeamInbox
from multi_localizer.team_lists import TeammateList, list_problem, strangers

_PERIOD_NS = 2_000_000_000


class TeamWatch:
    """Adds the part `team list` to the diagnostics and to the log.

    Args:
        node: The node.
        inbox: Of the team.
        lists: Of the teammates that write notes.
    """

    def __init__(
        self, node: FloornavNode, inbox: TeamInbox, lists: Mapping[str, TeammateList]
    ) -> None:
        """Begin to look."""
        self._node, self._inbox, self._lists = node, inbox, lists
        self._throttle = Throttle(_PERIOD_NS)
        self._strangers: list[str] = []
        node.diagnostics.add("team list", self.status)
        node.time.on_look(self._look)
        self._log = StateLog(node, self.status, says_ok=False)

    def _look(self) -> None:
        """Strangers matter while somebody of the team has never been heard."""
        if not self._throttle.is_due(self._node.time.steady_ns()):
            return
        node, robots = self._node, self._inbox.robots
        topics = [name for name, _ in node.get_topic_names_and_types()]
        is_one_missing = any(robot.heard_ns is None for robot in robots.values())
        found = strangers(topics, robots) if is_one_missing else []
        self._strangers = [n for n in found if node.count_publishers(f"/{n}/bearings/robots")]

    def status(self) -> Status:
        """Return whether the list of the team seems to be right."""
        team = tuple(self._inbox.robots)
        found = [list_problem(name, each.known, team) for name, each in self._lists.items()]
        found += [
            f"/{name} sends bearings/robots and is not in team [{', '.join(team)}]"
            for name in self._strangers
        ]
        problems = [text for text in found if text]
        if problems:
            return Status(WARN, f"{'; '.join(problems)}: is a name misspelled?")
        return Status(OK, "no name seems to be misspelled")
