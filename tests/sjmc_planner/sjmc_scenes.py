"""Builders for the tests of SJMC: a laser of half a degree, disks, a robot in steps."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.planning import STILL, Decision, Goal, Method, Obstacles, RobotState, Velocity
from sjmc_planner.sjmc_scene import Scene

PERIOD = 0.05
ROBOT = RobotConfig(
    drive="differential", radius_m=0.57, margin_m=0.05, front_m=0.2, rear_m=0.49,
    half_width_m=0.28, speed_m_s=0.8, accel_m_s2=0.8, yaw_rate_rad_s=1.2, yaw_accel_rad_s2=2.5,
    idle_time_s=0.1,
)  # fmt: skip
CONFIG = LocalPlannerConfig(method="sjmc", robot=ROBOT, control_period_s=PERIOD)
_NUM = 541


def scan_of(disks: list[tuple[float, float, float]], range_max: float = 6.0) -> Scan:
    """Return what a laser at the origin sees of disks: x, y, radius."""
    step = 1.5 * np.pi / (_NUM - 1)
    angles = -0.75 * np.pi + step * np.arange(_NUM)
    ranges = np.full(_NUM, np.inf)
    for x, y, radius in disks:
        along, across = (
            x * np.cos(angles) + y * np.sin(angles),
            y * np.cos(angles) - x * np.sin(angles),
        )
        is_hit = (np.abs(across) < radius) & (along > 0.0)
        end = along - np.sqrt(np.maximum(radius**2 - across**2, 0.0))
        ranges = np.where(is_hit, np.minimum(ranges, end), ranges)
    return Scan(np.where(ranges > range_max, np.inf, ranges), -0.75 * np.pi, step, 0.05, range_max)


def people_scene(*people: tuple[float, float, float, float], half_view: float = math.pi) -> Scene:
    """Return a scene with nothing but people of 0.25 m about: x, y, vx, vy."""
    rows = np.array([(*person, 0.25) for person in people]).reshape(-1, 5)
    angles = -math.pi + math.pi / 36.0 * np.arange(72)
    ranges = np.where(np.abs(angles) <= half_view, np.inf, np.nan)
    scan = Scan(ranges, -math.pi, math.pi / 36.0, 0.05, 6.0)
    ends = BeamReader(0.1).read(Obstacles(scan, SE2.identity()))
    none = np.zeros((0, 2))
    is_moving = np.hypot(rows[:, 2], rows[:, 3]) > 0.1
    return Scene(ends, none, none, rows, np.arange(len(rows)) + 7, is_moving)


def goal_at(x: float, y: float) -> Goal:
    """Return a goal that is to be reached itself."""
    return Goal(np.array([x, y]), float(np.hypot(x, y)))


def watched(
    method: Method, disks: list[tuple[float, ...]], goal: Goal, velocity: Velocity = STILL,
    num: int = 12, has_debug: bool = False,
) -> Decision:  # fmt: skip
    """Return what is decided after watching disks x, y, radius, vx, vy for some periods.

    The disks end where they are given, in the frame of a robot that moves at `velocity`.
    """
    moved = moved_by(velocity, PERIOD)
    for k in range(num):
        left = (num - 1 - k) * PERIOD
        T = moved_by(velocity, -left)  # the robot then, seen from the robot at the end
        places = []
        for x, y, radius, *way in disks:
            vx, vy = way or (0.0, 0.0)
            place = (T.inverse() @ np.array([[x - left * vx, y - left * vy]]))[0]
            places.append((float(place[0]), float(place[1]), radius))
        decision = method.decide(
            RobotState(velocity, velocity, moved if k else SE2.identity()),
            Obstacles(scan_of(places), SE2.identity()), goal, has_debug=has_debug,
        )  # fmt: skip
    return decision
