"""What the planner of ways says of a goal that was sent to it."""

from __future__ import annotations

import re

from sjmc_planner.route_keeper import NO_WAY, ON_ITS_WAY

_FIGURES = re.compile(r"\d+\.\d+ (s old|m left)")


class WayProgress:
    """Follows the part `path` of a planner of ways after a goal was sent.

    Args:
        goal: As `goal_name` gives it.

    Attributes:
        is_heard: Whether there is a planner of ways.
        has_goal: Whether it has this goal, and no other.
    """

    def __init__(self, goal: str) -> None:
        self._goal, self._end, self._said = goal, "", ""
        self.is_heard = self.has_goal = False
        self._no_way_since_ns: int | None = None

    def update(self, message: str, goal: str, end: str, now_ns: int) -> str:
        """Take what it says; return the line to be said of it, "" if there is none.

        Args:
            message: State and text.
            goal: The goal that it has.
            end: Where its path leads; "" for none.
            now_ns: Steady time.
        """
        self.is_heard, self.has_goal, self._end = True, goal == self._goal, end
        if not (self.has_goal and message.startswith(NO_WAY)):
            self._no_way_since_ns = None
        elif self._no_way_since_ns is None:
            self._no_way_since_ns = now_ns
        if not self.has_goal:
            return ""
        said, self._said = self._said, _FIGURES.sub("", message)
        is_plain = end != "" and (message.startswith((ON_ITS_WAY, "done", "idle")))
        return message if self._said != said and not is_plain else ""

    def no_way_s(self, now_ns: int) -> float:
        """Return for how long there has been no way to the goal, s."""
        since_ns = self._no_way_since_ns
        return 0.0 if since_ns is None else (now_ns - since_ns) * 1e-9

    def leads(self, target: str) -> bool | None:
        """Return whether who drives to a target drives to this goal; None: unknown.

        Args:
            target: As `planner/state` names it; "" if it does not.
        """
        if self.is_heard:
            return self.has_goal and self._end != "" and target in ("", self._end)
        return True if target == self._goal else None
