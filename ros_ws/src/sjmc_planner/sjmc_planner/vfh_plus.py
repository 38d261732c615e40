"""VFH+ (Ulrich and Borenstein 1998): the first of the published baselines.

The four stages stand in `polar_histogram` and `openings`; here they are put together, with what the
paper leaves to its robot:

- a laser's hits and misses fill the certainty grid (`certainty_window`);
- a direction that no beam looked along is blocked;
- what is farther than the goal does not count;
- turning circles are those of the present speed; if they block everything, those of half of it
  and of a quarter are taken and the robot drives no faster (the paper's "slower speed");
- speed comes from `steering`, which never drives faster than the robot can stop.
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.beam_ends import BeamEnds, BeamReader
from sjmc_planner.certainty_window import Cells, CertaintyWindow
from sjmc_planner.config import RobotConfig
from sjmc_planner.growth import grow, wedges_of
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.openings import candidates, cheapest
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
from sjmc_planner.polar_histogram import (
    binary_histogram,
    mask_limits,
    masked_histogram,
    primary_histogram,
)
from sjmc_planner.steering import Steering

_SPEEDS = (1.0, 0.5, 0.25)
_STANDS = 0.02  # slower than this it can turn where it is, m/s


class VfhPlus:
    """The method.

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
        self._bearings = np.arange(num) * (2.0 * math.pi / num)
        self._binary = np.zeros(num, dtype=bool)
        self._turned = 0.0  # by how many sectors, since the binary histogram was turned last
        self._chosen: float | None = None  # in the base frame

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now: the four stages."""
        if goal.distance <= self._cycle.goal_tolerance:
            return Decision(STILL, REACHED)
        ends = self._reader.read(obstacles)
        cells = self._window.update(ends, state.moved)
        self._turn_memory(state)
        is_blocked = self._blocked(ends, cells, goal)
        heading = self._steering.heading(state)
        bearings, share = self._candidates(is_blocked, cells, heading, state, goal)
        chosen = self._choice(bearings, heading, goal)
        decision = self._decision(bearings, chosen, share, state, ends, goal)
        if not has_debug:
            return decision
        debug = self._debug(obstacles, bearings, chosen)
        return Decision(decision.command, decision.state, decision.reason, debug)

    def _turn_memory(self, state: RobotState) -> None:
        """Carry what was chosen, and what was blocked, along with the robot's own turning."""
        if self._chosen is not None:
            self._chosen -= state.moved.yaw
        self._turned += state.moved.yaw * len(self._binary) / (2.0 * math.pi)
        num_sectors = round(self._turned)
        if num_sectors:
            self._turned -= num_sectors
            self._binary = np.roll(self._binary, -num_sectors)

    def _blocked(self, ends: BeamEnds, cells: Cells, goal: Goal) -> np.ndarray:
        """Return the binary histogram; sectors that no beam looked along are blocked too."""
        config = self._config
        reach = min(config.window_m, goal.distance + self._enlarged_by)
        primary = primary_histogram(
            cells.points, cells.certainty, self._enlarged_by, reach, config.near_weight,
            config.num_sectors,
        )  # fmt: skip
        self._binary = binary_histogram(
            primary, self._binary, config.threshold_low, config.threshold_high
        )
        return self._binary | ends.unseen(self._bearings, self._robot.radius_m, reach)

    def _candidates(
        self, is_blocked: np.ndarray, cells: Cells, heading: float, state: RobotState, goal: Goal
    ) -> tuple[np.ndarray, float]:
        """Return the candidates of the masked histogram, and the share of speed they are for."""
        speed = state.velocity.speed
        for share in _SPEEDS:
            radius = self._steering.turn_radius(share * speed) if speed > _STANDS else 0.0
            limits = mask_limits(cells.points, heading, radius, self._enlarged_by)
            masked = masked_histogram(is_blocked, heading, limits)
            if not masked.all():
                wide = min(self._config.wide_sectors, self._config.num_sectors)
                return candidates(masked, goal.bearing, wide), share
        return np.zeros(0), 0.0

    def _choice(self, bearings: np.ndarray, heading: float, goal: Goal) -> int:
        """Return the cheapest candidate; -1 if there is none."""
        if not len(bearings):
            self._chosen = None
            return -1
        config = self._config
        weights = config.goal_weight, config.heading_weight, config.steady_weight
        before = goal.bearing if self._chosen is None else self._chosen
        chosen = int(cheapest(bearings, goal.bearing, heading, before, weights))
        self._chosen = float(bearings[chosen])
        return chosen

    def _decision(
        self, bearings: np.ndarray, chosen: int, share: float, state: RobotState, ends: BeamEnds,
        goal: Goal,
    ) -> Decision:  # fmt: skip
        is_still = state.velocity.speed < _STANDS
        if chosen < 0:
            return Decision(STILL, BLOCKED if is_still else BRAKING, "no direction is open")
        speed = self._steering.fastest(goal)
        if share < 1.0:
            speed = min(speed, share * state.velocity.speed)
        horizon = ends.horizon - math.hypot(*ends.pose[:2])
        command = self._steering.toward(float(bearings[chosen]), speed, state, ends.points, horizon)
        if command is None:
            return Decision(STILL, BRAKING, "no room to stop within what is seen")
        if command.is_still:
            return Decision(STILL, BLOCKED, "something is too near on the open way")
        return Decision(command, DRIVING)

    def _debug(self, obstacles: Obstacles, bearings: np.ndarray, chosen: int) -> Debug:
        """Return the obstacles as they are enlarged, and the candidates as lines."""
        space = grow(wedges_of(obstacles, self._cycle.unseen_gap), self._enlarged_by, 360)
        ends = self._config.window_m * np.column_stack((np.cos(bearings), np.sin(bearings)))
        ways = [np.array([[0.0, 0.0], end]) for end in ends]
        return Debug(space.border(), ways, np.full(len(ways), np.inf), chosen)
