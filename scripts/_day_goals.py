"""Sends goals one after the other, as a person at a screen would; nothing here knows ROS."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from experiments.goal_record import GoalRecord
from sjmc_planner.goal_progress import GoalProgress

_AGAIN_NS = 3_000_000_000
_FIRST_NS = 500_000_000  # the first map comes a little after the first scan


class GoalSender:
    """Sends the next goal when one is reached, or not reached in time.

    Args:
        goals: Shape (N, 2), m.
        limit_s: A goal not reached in this time is left for the next.
        send: Sends one.
        record: Told what became of them.

    Attributes:
        number: Of the goal in force, from 0 on; -1 before the first.
        num_with_way: How many were answered by a way.
    """

    def __init__(
        self,
        goals: np.ndarray,
        limit_s: float,
        send: Callable[[np.ndarray], None],
        record: GoalRecord,
    ) -> None:
        self.number, self.num_with_way = -1, 0
        self._goals, self._limit_ns = goals, round(limit_s * 1e9)
        self._send, self._record = send, record
        self._progress = GoalProgress()
        self._has_way = False
        self._since_ns = self._sent_ns = 0

    @property
    def is_done(self) -> bool:
        """Whether the last goal is reached or left."""
        return self.number >= len(self._goals)

    def look(self, now_ns: int) -> None:
        """Send the first goal once it is time, one again that has no way, and leave a late one."""
        if self.is_done:
            return
        if self.number < 0:
            if now_ns >= _FIRST_NS:
                self._next(now_ns)
        elif now_ns - self._since_ns > self._limit_ns:
            self._record.given_up.append(self.number)
            self._next(now_ns)
        elif not self._has_way and now_ns - self._sent_ns >= _AGAIN_NS:
            self._sent_ns = now_ns
            self._send(self._goals[self.number])

    def has_way(self) -> None:
        """Take that a way came."""
        if 0 <= self.number < len(self._goals) and not self._has_way:
            self._has_way, self.num_with_way = True, self.num_with_way + 1

    def take_state(self, state: str, reason: str, now_ns: int) -> None:
        """Take what the planner says."""
        if self.number < 0 or self.is_done:
            return
        self._progress.update(state, reason)
        if self._has_way and self._progress.is_reached:
            self._record.reached_ns.append(now_ns)
            self._next(now_ns)

    def _next(self, now_ns: int) -> None:
        self.number += 1
        self._progress, self._has_way = GoalProgress(), False
        self._since_ns = self._sent_ns = now_ns
        if not self.is_done:
            self._send(self._goals[self.number])
