"""When following a path is over: there, or given up, and as which of Nav2's errors."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.se2 import SE2
from sjmc_planner.follow_config import FollowConfig
from sjmc_planner.planning import BACKING, BLOCKED, BRAKING, REACHED, WAITING

STOPPED = "stopped"
THERE = "NONE"
_STANDING = (BLOCKED, BRAKING, WAITING, BACKING)
_LATE = "CONTROLLER_TIMED_OUT"


@dataclass(frozen=True)
class Outcome:
    """How it ended.

    Attributes:
        code: Name of the error as in Nav2's FollowPath; `THERE` if it is there.
        text: Why, in words.
    """

    code: str
    text: str = ""


class FollowProgress:
    """Watches how a path is followed, from one control period to the next.

    Args:
        config: When to give up.
    """

    def __init__(self, config: FollowConfig) -> None:
        self._config = config
        self._from_mark = SE2.identity()  # the robot, from where it last got on
        self._without_progress = self._standing = self._missing = 0.0

    def update(self, state: str, reason: str, moved: SE2, dt: float) -> Outcome | None:
        """Return how it ended; None while it goes on.

        Args:
            state: As on `planner/state`.
            reason: Beside it.
            moved: The robot's motion since the last call.
            dt: The time since, s.
        """
        if state == REACHED:
            return Outcome(THERE)
        config = self._config
        self._note_motion(moved, dt)
        self._standing = self._standing + dt if state in _STANDING else 0.0
        self._missing = self._missing + dt if state == STOPPED else 0.0
        if self._missing > config.failure_tolerance_s:
            is_pose = reason.startswith(("pose", "goal"))
            return Outcome("TF_ERROR" if is_pose else _LATE, reason)
        if self._standing > config.patience_s:
            return Outcome("PATIENCE_EXCEEDED", reason)
        if self._without_progress > config.progress_s:
            text = f"moved less than {config.progress_m} m in {config.progress_s} s"
            return Outcome("FAILED_TO_MAKE_PROGRESS", text)
        return None

    def _note_motion(self, moved: SE2, dt: float) -> None:
        self._from_mark = self._from_mark @ moved
        self._without_progress += dt
        if self._from_mark.distance >= self._config.progress_m:
            self._from_mark, self._without_progress = SE2.identity(), 0.0
