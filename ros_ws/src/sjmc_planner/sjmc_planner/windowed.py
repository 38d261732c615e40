"""What `vff`, `vfh` and `vfh_plus` share: a scan into the certainty window, a direction driven.

What the papers leave to their robots is the same for all three: a laser's hits and misses fill the
certainty grid (`certainty_window`), cells beyond the goal do not count, and `steering` drives what
was chosen, no faster than the robot can stop, and nowhere that no beam looked along.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from sjmc_planner.beam_ends import BeamEnds, BeamReader
from sjmc_planner.certainty_window import Cells, CertaintyWindow
from sjmc_planner.config import RobotConfig
from sjmc_planner.growth import grow, wedges_of
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.planning import (
    BLOCKED,
    BRAKING,
    DRIVING,
    REACHED,
    STILL,
    Debug,
    Decision,
    Goal,
    Obstacles,
    RobotState,
)
from sjmc_planner.steering import STANDS, Steering


@dataclass(frozen=True)
class View:
    """What a method chooses by.

    Attributes:
        ends: What the scan shows.
        cells: What the window knows.
        reach: Cells farther than this do not count, m.
        heading: Direction that turning starts from, rad.
        state: How the robot moves.
        goal: Where to go.
    """

    ends: BeamEnds
    cells: Cells
    reach: float
    heading: float
    state: RobotState
    goal: Goal


@dataclass(frozen=True)
class Choice:
    """What a method chose.

    Attributes:
        bearings: Directions it weighed, shape (C,), rad.
        chosen: Index of the one taken; -1 for none.
        speed: No faster than this, m/s.
    """

    bearings: np.ndarray
    chosen: int
    speed: float


class WindowedMethod(ABC):
    """A method that chooses a direction by the cells of a window.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        cycle: Rhythm of the runner.
    """

    def __init__(self, robot: RobotConfig, config: HistogramConfig, cycle: Cycle) -> None:
        self._robot, self._config, self._cycle = robot, config, cycle
        self._enlarged_by = robot.grown_radius + 0.5 * config.cell_m
        self._reader = BeamReader(cycle.unseen_gap)
        self._window = CertaintyWindow(
            config.window_m, config.cell_m, config.hit_gain, config.miss_loss
        )
        self._steering = Steering(robot, cycle.period)
        num = config.num_sectors
        self._sectors = np.arange(num) * (2.0 * math.pi / num)  # their bearings, rad

    @abstractmethod
    def _choose(self, view: View) -> Choice:
        """Return the direction to take."""

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now."""
        if goal.distance <= self._cycle.goal_tolerance:
            return Decision(STILL, REACHED)
        ends = self._reader.read(obstacles)
        cells = self._window.update(ends, state.moved)
        reach = min(self._config.window_m, goal.distance + self._enlarged_by)
        heading = self._steering.heading(state)
        choice = self._choose(View(ends, cells, reach, heading, state, goal))
        decision = self._decision(choice, ends, state)
        if not has_debug:
            return decision
        debug = self._debug(obstacles, choice)
        return Decision(decision.command, decision.state, decision.reason, debug)

    def _decision(self, choice: Choice, ends: BeamEnds, state: RobotState) -> Decision:
        if choice.chosen < 0:
            stopped = BLOCKED if state.velocity.speed < STANDS else BRAKING
            return Decision(STILL, stopped, "no direction is open")
        bearing = float(choice.bearings[choice.chosen])
        command = self._steering.toward(bearing, choice.speed, state, ends)
        if command is None:
            return Decision(STILL, BRAKING, "no room to stop within what is seen")
        if command.is_still:
            return Decision(STILL, BLOCKED, "something is too near on the way chosen")
        return Decision(command, DRIVING)

    def _debug(self, obstacles: Obstacles, choice: Choice) -> Debug:
        """Return the obstacles grown by the robot, and the directions weighed as lines."""
        space = grow(wedges_of(obstacles, self._cycle.unseen_gap), self._robot.grown_radius, 360)
        units = np.column_stack((np.cos(choice.bearings), np.sin(choice.bearings)))
        ways = [np.array([[0.0, 0.0], self._config.window_m * unit]) for unit in units]
        return Debug(space.border(), ways, np.full(len(ways), np.inf), choice.chosen)
