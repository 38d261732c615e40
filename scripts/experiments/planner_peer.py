"""What the planners of others share behind the seam of ours."""

from __future__ import annotations

from abc import ABC, abstractmethod

from sjmc_planner.beam_ends import BeamEnds, BeamReader
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.planning import REACHED, STILL, Decision, Goal, Obstacles, RobotState
from sjmc_planner.steering import Steering


class Peer(ABC):
    """A planner that reads a scan and stops at its goal as ours do.

    Args:
        config: Robot, rhythm and tolerance.
    """

    def __init__(self, config: LocalPlannerConfig) -> None:
        self._config = config
        self._reader = BeamReader(config.unseen_gap_rad)
        self._steering = Steering(config.robot, config.control_period_s)

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now."""
        if goal.distance <= self._config.goal_tolerance_m:
            return Decision(STILL, REACHED)
        return self._drive(state, obstacles, self._reader.read(obstacles), goal)

    @abstractmethod
    def _drive(
        self, state: RobotState, obstacles: Obstacles, ends: BeamEnds, goal: Goal
    ) -> Decision:
        """Return the command on the way."""
