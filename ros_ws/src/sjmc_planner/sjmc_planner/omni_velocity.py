"""Avoidance that knows how the robot can accelerate (floor paper, 3.2), and the one that does not.

`omni_velocity` predicts for each of J directions where the robot would go under its acceleration
limit (eq. 11, 12), how long that is free of grown obstacles (eq. 13 to 15), and takes the direction
nearest the goal among those that are free for T_th (Step 5). `omni_static` is the paper's
comparison: it takes the robot to move along each direction at once, so T_j = r_o / v_c.

Where the paper is silent:
- no direction is free for T_th: the one free for longest, of equal ones that nearest the goal;
- a goal nearer than v_c T_th: what has to be free is the time to the goal, and v_c is no more than
  what the robot can brake from within that distance;
- of two directions equally far from the goal, that nearer to where the robot moves already.

Beyond the paper `omni_velocity` goes slower where nothing near the goal's direction is open at full
speed (`num_speeds`, `detour_rad`): the free way that T_th asks for shrinks with the speed, so gaps
are passed slowly instead of turned from. And it takes no direction from which, after one cycle, the
robot could no longer stop straight ahead within what it sees (`keeps_stoppable`); if there is none
it brakes. So a standing obstacle that is seen is not driven into; one that went nearer
than the sensor sees is remembered (`near_memory`). For a differential robot the ways
are those of `unicycle_motion`; all else is the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sjmc_planner.config import OmniConfig, RobotConfig
from sjmc_planner.free_times import first_stoppable, free_times, straight_free_times
from sjmc_planner.growth import GrownSpace, grow, wedges_of
from sjmc_planner.limited_motion import limited_position, stopping_speed
from sjmc_planner.near_memory import NearMemory
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
    Velocity,
)
from sjmc_planner.unicycle_motion import Unicycle

_NO_SPEED = 1e-3


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """What the runner of a method knows and the method must: its own rhythm.

    Attributes:
        period: Time between commands, s.
        goal_tolerance: This near is there, m.
        unseen_gap: See `growth.wedges_of`, rad.
    """

    period: float = 0.05
    goal_tolerance: float = 0.05
    unseen_gap: float = 0.1


def directions(num: int) -> np.ndarray:
    """Return the directions weighed, 2 pi (j - 1) / J (eq. 11), shape (J,), in (-pi, pi]."""
    angles = 2.0 * np.pi * np.arange(num) / num
    return np.where(angles > np.pi, angles - 2.0 * np.pi, angles)


def preference(
    times: np.ndarray,
    bearings: np.ndarray,
    goal: float,
    moving: float,
    clear_time: float,
    steady_weight: float = 0.0,
) -> np.ndarray:
    """Return the directions in the order in which they would be taken (Step 5).

    Args:
        times: How long each is free (T_j), shape (J,), s.
        bearings: The directions, shape (J,), rad.
        goal: Bearing of the goal, rad.
        moving: Bearing the robot moves along, rad.
        clear_time: How long a direction must be free (T_th), s.
        steady_weight: How much the angle to the present motion counts beside that to the goal.
    """
    off_moving = np.abs(_wrapped(bearings - moving))
    off_goal = np.round(np.abs(_wrapped(bearings - goal)) + steady_weight * off_moving, 6)
    is_open = times >= clear_time
    return np.lexsort((off_moving, off_goal, np.where(is_open, 0.0, -times), ~is_open))


class OmniVelocity:
    """The published method, for holonomic and differential robots.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        cycle: Rhythm of the runner.
    """

    has_velocity = True

    def __init__(self, robot: RobotConfig, config: OmniConfig, cycle: Cycle) -> None:
        self._robot, self._config, self._cycle = robot, config, cycle
        self._bearings = directions(config.num_directions)
        self._units = np.column_stack((np.cos(self._bearings), np.sin(self._bearings)))
        self._shortest = config.time_step_s if self.has_velocity else 0.0  # T_j of a way not free
        self._memory = NearMemory()
        self._unicycle = Unicycle(robot) if robot.drive == "differential" else None

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now (Steps 1 to 5)."""
        if goal.distance <= self._cycle.goal_tolerance:
            return Decision(STILL, REACHED)
        wedges = wedges_of(obstacles, self._cycle.unseen_gap)
        if self.has_velocity and self._config.remembers_near:
            wedges = self._memory.update(wedges, state.moved)
        space = grow(wedges, self._robot.grown_radius, self._config.num_bearings)  # Step 1
        speed, times, order = self._choose(state, goal, space)
        chosen = self._first_stoppable(order, state, speed, space)
        decision = self._decision(chosen, times, state, speed)
        if not has_debug:
            return decision
        debug = Debug(space.border(), self.ways(state.velocity, speed), times, chosen)
        return Decision(decision.command, decision.state, decision.reason, debug)

    def ways(self, velocity: Velocity, speed: float) -> list[np.ndarray]:
        """Return the predicted way of each direction up to T_th (Fig. 4c), shapes (K, 2), m."""
        t = np.arange(0.0, self._config.clear_time_s + 1e-9, self._config.time_step_s)
        if not self.has_velocity:
            return [speed * t[:, None] * unit for unit in self._units]
        if self._unicycle is not None:
            return self._unicycle.ways(velocity, self._bearings, speed, t)
        va = np.array([velocity.x, velocity.y])
        robot = self._robot
        return list(
            limited_position(va, speed * self._units, robot.accel_m_s2, robot.idle_time_s, t)
        )

    def _choose(
        self, state: RobotState, goal: Goal, space: GrownSpace
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the speed, T_j at that speed and the order of preference (Steps 3 to 5)."""
        fastest, clear_time = self._targets(goal)
        num = self._config.num_speeds if self.has_velocity else 1
        for level in range(num):
            speed = fastest * 0.5**level
            times = self._free_times(state.velocity, speed, clear_time, space)
            order = self._order(times, state, goal, clear_time)
            best = order[0]
            off = abs(math.remainder(float(self._bearings[best]) - goal.bearing, 2.0 * math.pi))
            if times[best] >= clear_time and off <= self._config.detour_rad:
                break
        return speed, times, order

    def _order(
        self, times: np.ndarray, state: RobotState, goal: Goal, clear_time: float
    ) -> np.ndarray:
        motion = state.velocity if state.velocity.speed > _NO_SPEED else state.command
        moving = math.atan2(motion.y, motion.x) if motion.speed > _NO_SPEED else goal.bearing
        return preference(
            times, self._bearings, goal.bearing, moving, clear_time,
            self._config.steady_weight if self.has_velocity else 0.0,
        )  # fmt: skip

    def _targets(self, goal: Goal) -> tuple[float, float]:
        """Return v_c and T_th, both no more than the goal's distance asks for."""
        robot = self._robot
        delay = robot.idle_time_s + self._cycle.period
        speed = min(robot.speed_m_s, stopping_speed(goal.distance, robot.accel_m_s2, delay))
        return speed, min(self._config.clear_time_s, goal.distance / max(speed, _NO_SPEED))

    def _free_times(
        self, velocity: Velocity, speed: float, clear_time: float, space: GrownSpace
    ) -> np.ndarray:
        robot, config = self._robot, self._config
        if not self.has_velocity:
            return straight_free_times(self._bearings, speed, space.seen)
        if self._unicycle is not None:
            return self._unicycle.free_times(
                velocity, self._bearings, speed, config.time_step_s, clear_time, space.seen
            )
        va = np.array([velocity.x, velocity.y])
        vb = speed * self._units  # eq. 11
        return free_times(
            va, vb, robot.accel_m_s2, robot.idle_time_s, config.time_step_s, clear_time, space.seen
        )

    def _first_stoppable(
        self, order: np.ndarray, state: RobotState, speed: float, space: GrownSpace
    ) -> int:
        """Return the first direction that leaves the robot able to stop; -1 if there is none."""
        if not (self.has_velocity and self._config.keeps_stoppable):
            return int(order[0])
        robot, t = self._robot, self._cycle.period
        if self._unicycle is not None:
            return self._unicycle.first_stoppable(
                order, state.velocity, self._bearings, speed, t, space.known
            )
        va = np.array([state.velocity.x, state.velocity.y])
        return int(
            first_stoppable(
                order, va, speed * self._units, robot.accel_m_s2, robot.idle_time_s, t, space.known
            )
        )

    def _decision(
        self, chosen: int, times: np.ndarray, state: RobotState, speed: float
    ) -> Decision:
        if chosen < 0:
            is_still = state.velocity.speed < 0.02
            reason = "no direction leaves room to stop within what is seen"
            return Decision(STILL, BLOCKED if is_still else BRAKING, reason)
        if self._unicycle is not None:
            command = self._unicycle.command(float(self._bearings[chosen]), speed)
        else:
            vx, vy = speed * self._units[chosen]
            command = Velocity(float(vx), float(vy), 0.0)
        if times[chosen] <= self._shortest:
            return Decision(STILL, BLOCKED, "no direction is free")
        return Decision(command, DRIVING)


class OmniStatic(OmniVelocity):
    """The paper's comparison: the same choice by distances alone."""

    has_velocity = False


def _wrapped(angles: np.ndarray) -> np.ndarray:
    return np.asarray(np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi)
