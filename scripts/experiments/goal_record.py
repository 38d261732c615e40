"""What is kept of a drive over several goals, whoever drove it: the judge looks at nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2


@dataclass
class GoalRecord:
    """A drive so far; stamps are of simulated time, poses in the world.

    Attributes:
        truth: (stamp_ns, true pose), one every 20 ms.
        touches: (stamp_ns, whether the robot touches anything but the floor), on change.
        people: (stamp_ns, places of everybody's middle, (N, 2), m).
        reached_ns: When each goal was reached, those reached only.
        states: (stamp_ns, state, reason) of the planner, on change.
        num_goals: Goals there are.
        given_up: Goals that were left because the robot did not get there in time.
    """

    truth: list[tuple[int, SE2]] = field(default_factory=list)
    touches: list[tuple[int, bool]] = field(default_factory=list)
    people: list[tuple[int, np.ndarray]] = field(default_factory=list)
    reached_ns: list[int] = field(default_factory=list)
    states: list[tuple[int, str, str]] = field(default_factory=list)
    num_goals: int = 0
    given_up: list[int] = field(default_factory=list)

    @property
    def sim_s(self) -> float:
        """Simulated time so far, s."""
        return self.truth[-1][0] * 1e-9 if self.truth else 0.0

    @property
    def way(self) -> np.ndarray:
        """Where the robot was: rows t, x, y, yaw, shape (N, 4)."""
        rows = [(ns * 1e-9, pose.x, pose.y, pose.yaw) for ns, pose in self.truth]
        return np.array(rows).reshape(-1, 4)

    @property
    def path_m(self) -> float:
        """Distance driven in truth, m."""
        return float(np.hypot(*np.diff(self.way[:, 1:3], axis=0).T).sum())

    def note_touch(self, stamp_ns: int, is_touching: bool) -> None:
        """Take whether the robot touches something now."""
        if is_touching != (bool(self.touches) and self.touches[-1][1]):
            self.touches.append((stamp_ns, is_touching))

    def note_state(self, stamp_ns: int, state: str, reason: str) -> None:
        """Take what the planner says."""
        if not self.states or self.states[-1][1:] != (state, reason):
            self.states.append((stamp_ns, state, reason))
