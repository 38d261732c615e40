"""Backing out of where no course is open, on the way that the robot came."""

from __future__ import annotations

from sjmc_planner.planning import TURNING, Decision, RobotState
from sjmc_planner.sjmc_config import SjmcConfig

_STUCK_S = 1.0  # without a course in all, since it drove last
_FAR_M = 0.2  # so far back is enough to try again
_DRIVES = 0.1  # m/s


class Retreat:
    """Knows how far the robot may back, and when it should.

    Args:
        config: How far it may.
        period: Time between two calls, s.
    """

    def __init__(self, config: SjmcConfig, period: float) -> None:
        self._most, self._period = config.backs_off_m, period
        self._stuck_s, self._left = 0.0, 0.0
        self.behind = 0.0

    def note(self, state: RobotState) -> None:
        """Keep `behind`, how far it may back on the way that it came, m."""
        came = self.behind + state.moved.x - 2.0 * abs(state.moved.yaw) * self._most
        self.behind = min(max(came, 0.0), self._most)
        self._left = max(self._left + min(state.moved.x, 0.0), 0.0)
        if abs(state.velocity.x) > _DRIVES:
            self._stuck_s = 0.0

    def is_due(self, decision: Decision | None) -> bool:
        """Tell whether to back now; a course that comes and goes is none.

        Args:
            decision: What else there is to do; None = there is no course.
        """
        if decision is None:
            self._stuck_s += self._period
        elif decision.state != TURNING:
            self._stuck_s = self._left = 0.0
        if self._stuck_s > _STUCK_S:
            self._stuck_s, self._left = 0.0, _FAR_M
        return self._left > 0.0 and self.behind > 0.0

    def end(self) -> None:
        """Back no more: it cannot."""
        self._left = 0.0
