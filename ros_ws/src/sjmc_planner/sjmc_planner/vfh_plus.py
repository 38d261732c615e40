"""VFH+ (Ulrich and Borenstein 1998): four stages from a certainty grid to a direction.

The stages stand in `polar_histogram` and `openings`; here they are put together. What the paper
leaves open:

- a direction that no beam looked along is blocked;
- turning circles are those of the present speed; if they block everything, those of half of it
  and of a quarter are taken and the robot drives no faster (the paper's "slower speed").
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.openings import candidates, cheapest
from sjmc_planner.polar_histogram import (
    binary_histogram,
    mask_limits,
    masked_histogram,
    primary_histogram,
)
from sjmc_planner.steering import STANDS
from sjmc_planner.windowed import Choice, View, WindowedMethod

_SPEEDS = (1.0, 0.5, 0.25)
_TURN = 2.0 * math.pi


class VfhPlus(WindowedMethod):
    """The method.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        cycle: Rhythm of the runner.
    """

    def __init__(self, robot: RobotConfig, config: HistogramConfig, cycle: Cycle) -> None:
        super().__init__(robot, config, cycle)
        self._binary = np.zeros(config.num_sectors, dtype=bool)
        self._turned = 0.0  # by how many sectors, since the binary histogram was turned last
        self._chosen: float | None = None  # in the base frame, rad

    def _choose(self, view: View) -> Choice:
        """Return the direction to take: the four stages."""
        self._turn_memory(view.state.moved.yaw)
        is_blocked = self._blocked(view)
        bearings, share = self._candidates(is_blocked, view)
        chosen = self._cheapest(bearings, view)
        speed = self._steering.fastest(view.goal)
        if share < 1.0:
            speed = min(speed, share * view.state.velocity.speed)
        return Choice(bearings, chosen, speed)

    def _turn_memory(self, yaw: float) -> None:
        """Carry what was chosen, and what was blocked, along with the robot's own turning."""
        if self._chosen is not None:
            self._chosen -= yaw
        self._turned += yaw * len(self._binary) / _TURN
        num_sectors = round(self._turned)
        if num_sectors:
            self._turned -= num_sectors
            self._binary = np.roll(self._binary, -num_sectors)

    def _blocked(self, view: View) -> np.ndarray:
        """Return the binary histogram; sectors that no beam looked along are blocked too."""
        config = self._config
        primary = primary_histogram(
            view.cells.points, view.cells.certainty, self._enlarged_by, view.reach,
            config.near_weight, config.num_sectors,
        )  # fmt: skip
        self._binary = binary_histogram(
            primary, self._binary, config.threshold_low, config.threshold_high
        )
        return self._binary | view.ends.unseen(self._sectors, self._robot.radius_m, view.reach)

    def _candidates(self, is_blocked: np.ndarray, view: View) -> tuple[np.ndarray, float]:
        """Return the candidates of the masked histogram, and the share of speed they are for."""
        speed = view.state.velocity.speed
        for share in _SPEEDS:
            radius = self._steering.turn_radius(share * speed) if speed > STANDS else 0.0
            limits = mask_limits(view.cells.points, view.heading, radius, self._enlarged_by)
            masked = masked_histogram(is_blocked, view.heading, limits)
            if not masked.all():
                wide = min(self._config.wide_sectors, self._config.num_sectors)
                return candidates(masked, view.goal.bearing, wide), share
        return np.zeros(0), 0.0

    def _cheapest(self, bearings: np.ndarray, view: View) -> int:
        """Return the cheapest candidate; -1 if there is none."""
        if not len(bearings):
            self._chosen = None
            return -1
        config, goal = self._config, view.goal.bearing
        weights = config.goal_weight, config.heading_weight, config.steady_weight
        before = goal if self._chosen is None else self._chosen
        chosen = int(cheapest(bearings, goal, view.heading, before, weights))
        self._chosen = float(bearings[chosen])
        return chosen
