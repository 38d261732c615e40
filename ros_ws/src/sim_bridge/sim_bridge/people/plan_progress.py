"""How far one walker has come on its plan."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim_bridge.people.schema import WalkerPlan
from sim_bridge.people.yielding import Robot

_ARRIVED = 0.3
_SLOWS_DOWN_S = 0.6


class PlanProgress:
    """Start, way points and pauses of one walker.

    Args:
        plan: Where it goes.
        speed: Its walking speed, m/s.
        radius: Of its body, m.
    """

    def __init__(self, plan: WalkerPlan, speed: float, radius: float) -> None:
        self._plan, self._speed, self._radius = plan, speed, radius
        self._points = np.array(plan.path_m, dtype=float)
        self._target, self._way = 1, 1
        self._pause = self._pause_at(0)
        self._has_started = False

    def first_yaw(self) -> float:
        """Return where it faces at first, rad: to the next way point, else along x."""
        if len(self._points) < 2:
            return 0.0
        return math.atan2(*(self._points[1] - self._points[0])[::-1])

    def look(self, time: float, position: np.ndarray, robots: Sequence[Robot], dt: float) -> None:
        """Set out once it is time to, rest, and pass way points that are reached."""
        if not self._has_started:
            within = self._plan.starts_within_m
            is_near = within == 0.0 or any(
                robot.sensed_distance(position) - self._radius <= within for robot in robots
            )
            self._has_started = time >= self._plan.starts_s - 1e-9 and is_near
        elif self._pause > 0.0:
            self._pause -= dt
        if self._plan.is_reacting and self.is_under_way():
            self._arrive_near(position)

    def wanted(self, position: np.ndarray) -> np.ndarray:
        """Return the velocity that a reacting walker would like, (2,)."""
        index = self._target if self.is_under_way() else self._last()
        way = self._points[index] - position
        distance = float(np.hypot(*way))
        is_stop = not self.is_under_way() or self._is_end(index)
        speed = min(self._speed, distance / _SLOWS_DOWN_S) if is_stop else self._speed
        return np.asarray(speed * way / max(distance, 1e-9))

    def advance(self, position: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return position and velocity of a scripted walker after a step, (2,) each."""
        start, left = position, dt
        while left > 1e-12 and self.is_under_way():
            way = self._points[self._target] - position
            distance = float(np.hypot(*way))
            if distance > self._speed * left:
                position = position + self._speed * left * way / distance
                break
            position, left = self._points[self._target].copy(), left - distance / self._speed
            self._arrive()
        return position, (position - start) / dt

    def _arrive_near(self, position: np.ndarray) -> None:
        if float(np.hypot(*(self._points[self._target] - position))) < _ARRIVED:
            self._arrive()

    def _arrive(self) -> None:
        """Choose the next way point, and rest where the plan says so."""
        self._pause = self._pause_at(self._target)
        last = len(self._points) - 1
        if self._plan.repeats and last > 0 and not 0 <= self._target + self._way <= last:
            self._way = -self._way
        self._target += self._way

    def is_under_way(self) -> bool:
        """Tell whether it walks: it has set out, does not rest and is not at the end."""
        is_open = 0 <= self._target < len(self._points)
        return self._has_started and self._pause <= 1e-9 and is_open

    def _last(self) -> int:
        """Return the way point where it rests."""
        if not self._has_started:
            return 0
        return min(max(self._target - self._way, 0), len(self._points) - 1)

    def _is_end(self, index: int) -> bool:
        return not self._plan.repeats and index == len(self._points) - 1

    def _pause_at(self, index: int) -> float:
        pauses = self._plan.pauses_s
        return pauses[index] if index < len(pauses) else 0.0
