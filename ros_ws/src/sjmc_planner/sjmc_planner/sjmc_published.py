"""SJMC as the thesis ran it: eq. 4.5, and courses by a threshold on the scan (4.3).

The nearest thing in the way sets the speed, (l - L_DANGER) / C, and the course is the direction
nearest the target's in which nothing is within L_DANGER (4.3.2, Fig. 4.4). Where the thesis is
silent:
- a direction is one for the whole robot: nothing within L_DANGER in the strip that it would drive
  through, not in one beam alone (3.7: D goes with the course);
- nothing behind the target is in the way;
- with eq. 4.5 the distance to a thing decays to L_DANGER and never gets there. Waiting ends when
  the rule leaves no more than `published_end_m_s`: the thing is judged not to yield, and its
  distance at that time stands for L_DANGER until the course to the target is open again;
- no direction is open: it turns to the one open farthest, at the speed that eq. 4.5 allows there;
- where no beam looked it does not drive; what is too near to be measured is in the way.
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import stopping_speed
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.planning import (
    BLOCKED,
    DRIVING,
    REACHED,
    STILL,
    TURNING,
    Decision,
    Goal,
    Obstacles,
    RobotState,
    Velocity,
)
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_course import courses, nearest_open
from sjmc_planner.sjmc_region import box_of, free_ways
from sjmc_planner.sjmc_speed import simple_bound
from sjmc_planner.unicycle_motion import Unicycle

_STEP = math.radians(1.0)
_WIDEST = math.radians(135.0)
_LOOKS = 4.0  # times the robot's radius: how far a direction must have been looked along
_JUDGED_AIR = 0.1  # beyond the distance at which it was judged, m
_ON_COURSE = 0.02


class SjmcPublished:
    """The thesis's rule, for holonomic and differential robots.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        cycle: Rhythm of the runner.
    """

    def __init__(self, robot: RobotConfig, config: SjmcConfig, cycle: Cycle) -> None:
        self._robot, self._config, self._cycle = robot, config, cycle
        box = box_of(robot).grown(robot.margin_m)
        self._front, self._half = box.front, box.half_width
        self._reader = BeamReader(cycle.unseen_gap)
        self._unicycle = Unicycle(robot) if robot.drive == "differential" else None
        self._danger = config.published_danger_m

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now (Fig. 3.3: course, avoidance; the end comes first here)."""
        del state, has_debug
        if goal.distance <= self._cycle.goal_tolerance:
            return Decision(STILL, REACHED)
        ends = self._reader.read(obstacles)
        sensor = np.array(ends.pose[:2])
        reach = float(np.hypot(*goal.point)) + self._front
        bearings = courses(goal.bearing, _STEP, _WIDEST)
        free = self._distances(bearings, ends.points, sensor, reach)
        looked = self._robot.radius_m, _LOOKS * self._robot.radius_m
        free[ends.unseen(bearings, *looked)] = 0.0
        self._judge(float(free[0]))
        chosen = nearest_open(free, self._danger)
        course = float(bearings[chosen if chosen >= 0 else int(np.argmax(free))])
        way = np.array([0.0 if self._unicycle is not None else course])  # as the robot faces
        is_blind = bool(ends.unseen(way, *looked)[0])
        distance = 0.0 if is_blind else float(self._distances(way, ends.points, sensor, reach)[0])
        return self._decision(course, distance, chosen, goal, is_blind=is_blind)

    def _distances(
        self, bearings: np.ndarray, points: np.ndarray, sensor: np.ndarray, reach: float
    ) -> np.ndarray:
        """Return how far from the sensor the nearest thing in each course's way is, (K,), m."""
        from_base = free_ways(bearings, points, np.zeros(len(points)), 0.0, self._half)
        units = np.column_stack((np.cos(bearings), np.sin(bearings)))
        return np.where(from_base > reach, np.inf, from_base - units @ sensor)

    def _judge(self, to_target: float) -> None:
        """End the waiting for what stands in the way to the target."""
        config = self._config
        if to_target > self._danger:
            self._danger = config.published_danger_m
        bound = simple_bound(to_target, config.published_danger_m, config.published_response_s)
        if bound <= config.published_end_m_s:
            self._danger = max(self._danger, to_target + _JUDGED_AIR)

    def _decision(
        self, course: float, distance: float, chosen: int, goal: Goal, *, is_blind: bool
    ) -> Decision:
        config, robot = self._config, self._robot
        bound = simple_bound(distance, config.published_danger_m, config.published_response_s)
        delay = robot.idle_time_s + self._cycle.period
        stop = stopping_speed(goal.distance, robot.accel_m_s2, delay)
        speed = 0.0 if is_blind else min(bound, robot.speed_m_s, stop)
        reason = "the way ahead is not seen" if is_blind else ""
        if chosen < 0:
            reason = "no course without an obstacle in the Danger Zone"
        is_straight = abs(math.remainder(course - goal.bearing, 2.0 * math.pi)) < _ON_COURSE
        status = BLOCKED if chosen < 0 else DRIVING if is_straight else TURNING
        if self._unicycle is not None:
            return Decision(self._unicycle.command(course, speed), status, reason)
        command = Velocity(speed * math.cos(course), speed * math.sin(course), 0.0)
        return Decision(command, status, reason)
