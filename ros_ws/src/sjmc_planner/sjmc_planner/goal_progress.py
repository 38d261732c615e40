"""What a planner's states say of a goal that was sent to it."""

from __future__ import annotations

import re

from sjmc_planner.planning import REACHED

_IDLE = "idle"
_FIGURES = re.compile(r"[-\d.]+")
_SURELY = 6  # states in a row, 3 s: it has the goal by then


def goal_name(frame: str, x: float, y: float) -> str:
    """Return a goal as the planners name it beside their states: `map (1.000, -0.500)`."""
    return f"{frame.strip('/')} ({round(x, 3) + 0.0:.3f}, {round(y, 3) + 0.0:.3f})"


class GoalProgress:
    """Follows the states of a planner after a goal was sent.

    A planner that stood at its last goal may say so once more before it has the new one, so
    "reached" counts at once only of this goal, or after the planner was on its way.

    Attributes:
        is_reached: Whether it stands at the goal.
        is_idle: Whether it said last that it has no goal.
    """

    def __init__(self) -> None:
        self.is_reached = self.is_idle = False
        self._is_on_its_way = False
        self._num_reached = 0
        self._said = ("", "")

    def update(self, state: str, reason: str, is_this: bool | None = None) -> str:
        """Take a state; return the line to be said of it, "" if it was said before.

        Args:
            state: As on `planner/state`.
            reason: Beside it; figures, and what is behind " is ", make no new line.
            is_this: Whether the planner drives to this goal, and not to one before; None: unknown.
        """
        self.is_idle = state == _IDLE
        self._is_on_its_way |= is_this is not False and state not in (REACHED, _IDLE, "")
        self._num_reached = self._num_reached + 1 if state == REACHED else 0
        is_surely = self._is_on_its_way or self._num_reached >= _SURELY
        self.is_reached = state == REACHED and (is_surely if is_this is None else is_this)
        if state == REACHED and not self.is_reached:
            return ""
        said, self._said = self._said, (state, _FIGURES.sub("", reason.split(" is ")[0]))
        return (f"{state}: {reason}" if reason else state) if self._said != said else ""
